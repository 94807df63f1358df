// A look inside a step, by a step really done there: what it shows, what it costs, and that the run doesn't notice.
#include <phistep/phistep.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <vector>

#include "problems/prothero_robinson.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::Vector2d;

namespace {

/// A rotation that hardens, and can be made to fail.
struct Turn {
  double* limit = nullptr;  ///< beyond this t: NaN, or an exception
  bool throws = false;
  Vec operator()(const Vec& y, double t) const {
    if (limit != nullptr && t > *limit) {
      if (throws) throw std::runtime_error("no");
      return {std::nan(""), 0};
    }
    return {y[1], -y[0] * (1 + y[0] * y[0])};
  }
};

/// y' = −n y in the n-th step.
struct Counter : ForceTerm {
  struct Memory {
    int steps = 0;
  };
  static constexpr bool uses_time = false;
  void add(double, const auto& y, const Memory& m, auto& out) const { out.rate -= (1.0 + m.steps) * y.y; }
  void commit(double, const auto&, Memory& m) const { ++m.steps; }
};

}  // namespace

TEST_CASE("at a fixed dt, a scheme that solves equations or is of high order is asked by a step done there") {
  const auto check = [](auto scheme, double dt) {
    Vec y(1, 0.5);
    PhiStepper stepper{y, Turn{}, scheme};
    int looks = 0;
    const auto report = integrate(stepper, y, {0, 4 * dt}, fixed(dt), [&](const auto& step) {
      for (const double x : {0.3, 0.8}) {
        Vec alone = step.start();
        PhiStepper fresh{alone, Turn{}, scheme};
        REQUIRE(fresh.step(alone, step.t0(), x * step.dt()));
        const double off = (step.at(step.t0() + x * step.dt()) - alone).norm();
        CHECK(off <= 1e-10);  // solves are to 1e-10 and better
        ++looks;
      }
    });
    CHECK(report);
    CHECK(looks == 8);
  };
  for (const double dt : {0.4, -0.4}) {
    check(trapezoidal, dt);
    check(rodas5p, dt);
  }
}

TEST_CASE("a look changes no bit of the run and no count of its stepper, and the report tells what it cost") {
  const auto check = [](auto scheme, const auto& control) {
    const auto run = [&](bool looks) {
      Vec y(1, 0.5);
      PhiStepper stepper{y, Turn{}, scheme};
      const RunReport report = integrate(stepper, y, {0, 3}, control, [looks](const auto& step) {
        if (looks) return step.at(step.t0() + step.dt() / 3).allFinite();
        return true;
      });
      CHECK(report);
      return std::tuple{y, stepper.statistics(), report.statistics};
    };
    const auto [y, work, told] = run(true);
    const auto [alone, alone_work, alone_told] = run(false);
    CHECK(y == alone);
    CHECK(told.steps == alone_told.steps);
    CHECK(told.rejections == alone_told.rejections);
    CHECK(alone_told.force_calls == alone_work.force_calls);
    CHECK(told.force_calls > alone_told.force_calls);
    CHECK(told.factorizations > alone_told.factorizations);
    CHECK(work.steps == alone_work.steps);
    CHECK(work.factorizations == alone_work.factorizations);
  };
  check(tr_bdf2, tolerance{.rtol = 1e-4});
  check(radau, tolerance{.rtol = 1e-6});
  check(trapezoidal, fixed(0.25));
}

TEST_CASE("an explicit scheme of order 2 is interpolated: no step is done for a look") {
  Motion<Vec> y{Vec(1, 0), Vec(0, 1)};
  PhiStepper stepper{y, [](const Vec& r) -> Vec { return -r; }, velocity_verlet};
  const auto report = integrate(stepper, y, {0, 1}, fixed(0.1), [](const auto& step) {
    for (const double x : {0.2, 0.4, 0.6}) REQUIRE(step.at(step.t0() + x * step.dt()).r.allFinite());
  });
  // A call a step and one to begin with; two slopes a step that is looked into.
  CHECK(report.statistics.force_calls == 11 + 2 * 10);
}

TEST_CASE("a look that a force fails ends the run there, one where it throws passes the exception on") {
  for (const bool throws : {false, true}) {
    double limit = std::numeric_limits<double>::infinity();
    Vec y(1, 0.5);
    PhiStepper stepper{y, Turn{&limit, throws}, trapezoidal};
    Vec end;
    const auto go = [&] {
      return integrate(stepper, y, {0, 3}, fixed(0.5), [&](const auto& step) {
        if (step.t1() < 1.4) return;
        end = step.end();
        limit = step.t0();
        static_cast<void>(step.at(step.t0() + 0.2));
      });
    };
    if (throws) {
      CHECK_THROWS_AS(go(), std::runtime_error);
    } else {
      const auto report = go();
      CHECK(report.outcome == Outcome::non_finite_force);
      CHECK(report.t == 1.5);
    }
    CHECK(y == end);
  }
}

TEST_CASE("a look starts from the history that the step started from, and leaves the one that it left") {
  Vec y(1, 2);
  PhiStepper stepper{y, Counter{}, backward_euler};
  double n = 0;
  const auto report = integrate(stepper, y, {0, 1}, fixed(0.25), [&](const auto& step) {
    n += 1;
    const double half = step.dt() / 2;
    CHECK((step.at(step.t0() + half) - step.start() / (1 + n * half)).norm() <= 1e-12);
    CHECK((step.end() - step.start() / (1 + n * step.dt())).norm() <= 1e-12);
  });
  CHECK(report);
  CHECK(stepper.memory().steps == 4);
}

TEST_CASE("each of several looks into one step starts from the history that the step started from") {
  Eigen::Matrix<double, 1, 1> y(1.0), z(1.0);
  PhiStepper stepper{y, Counter{}, backward_euler}, other{z, Counter{}, backward_euler};
  const auto at = [](const auto& step, std::initializer_list<double> places) {
    double last = 0;
    for (const double x : places) last = step.at(step.t0() + x * step.dt())[0];
    return last;
  };
  std::vector<double> many, one;
  REQUIRE(integrate(stepper, y, {0, 0.4}, fixed(0.1), [&](const auto& step) {
    many.push_back(at(step, {0.2, 0.9, 0.6}));
  }));
  REQUIRE(integrate(other, z, {0, 0.4}, fixed(0.1), [&](const auto& step) { one.push_back(at(step, {0.6})); }));
  CHECK(many == one);
}

TEST_CASE("many looks into one step under a tolerance are each as accurate as the step") {
  Motion<Vec> y{{1, 0}, {0, 1.2}};
  const auto kepler = [](const Vec& r) -> Vec { return -r / std::pow(r.norm(), 3); };
  PhiStepper stepper{y, kepler, rkn86};
  double worst = 0;
  const auto look = [&](const auto& step) {
    for (int k = 1; k < 40; ++k) {
      const double t = step.t0() + k / 40.0 * step.dt();
      Motion<Vec> alone = step.start();
      PhiStepper fresh{alone, kepler, rkn86};
      REQUIRE(integrate(fresh, alone, {step.t0(), t}, tolerance{.rtol = 1e-12}));
      worst = std::max(worst, (step.at(t).v - alone.v).norm());
    }
  };
  REQUIRE(integrate(stepper, y, {0, 10}, tolerance{.rtol = 1e-8}, look));
  CHECK(worst <= 4e-8);  // velocities are of size 1
}

TEST_CASE("a view of the user's memory shows the step's end before and after a look") {
  double memory[2] = {1, 0.5};
  Eigen::Map<Vec> y{memory};
  PhiStepper stepper{y, [](const Vec& x) -> Vec { return {x[1], -x[0]}; }, rodas4};
  const auto report = integrate(stepper, y, {0, 2}, tolerance{.rtol = 1e-6}, [&](const auto& step) {
    const double t = step.t0() + step.dt() / 2;
    const Vec exact(std::cos(t) + 0.5 * std::sin(t), 0.5 * std::cos(t) - std::sin(t));
    CHECK((step.at(t) - exact).norm() <= 1e-5);
    CHECK((memory[0] == step.end()[0] && memory[1] == step.end()[1]));
  });
  CHECK(report);
}

TEST_CASE("an event is no root of an interpolant that is far off") {
  // cos t, stiffly: found before, four times 0.99 reached on (0, 10], one of them at cos t = 0.28.
  using One = problems::ProtheroRobinson::State;
  const auto check = [](auto scheme, double lambda, double rtol) {
    One y(1.0);
    PhiStepper stepper{y, problems::ProtheroRobinson{lambda}, scheme};
    auto high = event([](double, const One& x) { return x[0] - 0.99; });
    auto zero = event([](double, const One& x) { return x[0]; });
    CHECK(integrate(stepper, y, {0, 10}, tolerance{.rtol = rtol, .atol = rtol}, high, zero));
    CAPTURE(lambda, rtol, high.times(), zero.times());
    CHECK(high.times().size() <= 3);
    CHECK(zero.times().size() <= 3);
    for (const double t : high.times()) CHECK(std::abs(std::cos(t) - 0.99) <= 10 * rtol);
    for (const double t : zero.times()) CHECK(std::abs(std::cos(t)) <= 10 * rtol);
  };
  for (const double lambda : {-1e4, -1e6})
    for (const double rtol : {1e-3, 1e-4, 1e-5}) {
      check(rodas4, lambda, rtol);
      check(tr_bdf2, lambda, rtol);
    }
}
