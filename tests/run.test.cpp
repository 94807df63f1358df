// Runs controlled by their error, and runs step by step: what users and their observers may do to them.
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "contract/states.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using problems::distance;
using Vec = Eigen::Vector2d;
using Moving = Motion<Vec>;
using Flow = problems::ForcedFlow<>;
using Swing = problems::ForcedMotion<>;

namespace {

const double NaN = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

const auto decay = [](const Vec& y) -> Vec { return Vec(-y[0], -2 * y[1]); };
Vec decayed(double t) { return {std::exp(-t), std::exp(-2 * t)}; }

/// y' = y² blows up at t = 1 where y(0) = 1.
const auto square = [](const Vec& y) -> Vec { return y.cwiseProduct(y); };

void for_each_scheme(auto&& f) {
  f("backward_euler", backward_euler), f("phi(0.7)", phi(0.7)), f("trapezoidal", trapezoidal), f("midpoint", midpoint);
  f("tr_bdf2", tr_bdf2), f("forward_euler", forward_euler), f("rannacher", rannacher);
}

}  // namespace

TEST_CASE("every scheme ends at t1 itself, near the truth, forward and backward") {
  for_each_scheme([](const char* name, auto scheme) {
    for (const double t1 : {1.7, -1.1}) {
      CAPTURE(name, t1);
      Vec y = Flow::exact(0.3);
      PhiStepper stepper{y, Flow{}, scheme, capacity(Flow::capacity)};
      const double rtol = 1e-4;
      // Backward the problem grows by e^{-λt}, λ ≥ −5 at M = 1.5 and 1.4 time units: errors by 1e2.
      const RunReport report = integrate(stepper, y, {0.3, t1}, tolerance{.rtol = rtol});
      REQUIRE(report);
      CHECK(report.t == t1);
      CHECK(distance(y, Flow::exact(t1)) <= (t1 > 0 ? 10 : 1000) * rtol);
    }
  });
  const auto motion = [](auto scheme) {
    for (const double t1 : {2.3, -1.1}) {
      Moving y = Swing::exact(0.3);
      PhiStepper stepper{y, Swing{}, scheme, mass(Swing::mass)};
      const RunReport report = integrate(stepper, y, {0.3, t1}, tolerance{.rtol = 1e-4});
      REQUIRE(report);
      CHECK(report.t == t1);
      CHECK(distance(y, Swing::exact(t1)) <= (t1 > 0 ? 1e-3 : 1e-2));
    }
  };
  motion(velocity_verlet), motion(trapezoidal), motion(symplectic_euler), motion(tr_bdf2), motion(backward_euler);
}

TEST_CASE("given times are hit to the last bit: random ones, forward and backward, fixed and controlled") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(-2, 3);
  std::vector<double> times(300);
  for (double& t : times) t = any(random);
  for (int k = 0; k < 20; ++k) times.push_back(times[static_cast<std::size_t>(k)] * (1 + 1e-15 * k));
  for (int k = 1; k < 40; ++k) times.push_back(-1.5 + 0.1 * k);  // grid points, or next to them
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  const auto check = [&](double t0, double t1, auto scheme, const auto& control) {
    std::vector<double> expected, seen;
    for (const double t : times)
      if (t >= std::min(t0, t1) && t <= std::max(t0, t1)) expected.push_back(t);
    if (t1 < t0) std::reverse(expected.begin(), expected.end());
    Vec y = Flow::exact(t0);
    PhiStepper stepper{y, Flow{}, scheme, capacity(Flow::capacity)};
    double worst = 0;
    const RunReport report = integrate(stepper, y, {t0, t1}, control, at_times(times, [&](double t, const Vec& now) {
                                         seen.push_back(t);
                                         worst = std::max(worst, distance(now, Flow::exact(t)));
                                       }));
    REQUIRE(report);
    CHECK(report.t == t1);
    CHECK(seen == expected);
    CHECK(worst <= 0.01);
  };
  check(-1.5, 2.5, trapezoidal, fixed(0.1));
  check(-1.5, 2.5, trapezoidal, tolerance{.rtol = 1e-4});
  check(-1.5, 2.5, tr_bdf2, tolerance{.rtol = 1e-4});
  check(-1.5, 2.5, midpoint, tolerance{.rtol = 1e-4});
  check(-1.5, 2.5, backward_euler, tolerance{.rtol = 1e-3});
  check(0.7, -0.4, trapezoidal, fixed(0.05));
  check(0.7, -0.4, trapezoidal, tolerance{.rtol = 1e-4});
  check(0.7, -0.4, rannacher, tolerance{.rtol = 1e-4});
}

TEST_CASE("stops between grid points leave the grid of a fixed run where it is") {
  Vec y = Flow::exact(0);
  PhiStepper stepper{y, Flow{}, trapezoidal, capacity(Flow::capacity)};
  std::vector<double> seen;
  const RunReport report =
      integrate(stepper, y, {0, 1}, fixed(0.1), at_times({0.25, 0.30000000000000001, 0.77}, [](double, const Vec&) {}),
                [&](double t, const Vec&) { seen.push_back(t); });
  REQUIRE(report);
  CHECK(report.statistics.steps == 12);  // 0.3 and 3·0.1 are one
  REQUIRE(seen.size() == 13);
  CHECK(seen[2] == 2 * 0.1);
  CHECK(seen[3] == 0.25);
  CHECK(seen[4] == 0.3);
  CHECK(seen[5] == 4 * 0.1);
  CHECK(seen[8] == 7 * 0.1);
  CHECK(seen[9] == 0.77);
  CHECK(seen[10] == 8 * 0.1);
}

TEST_CASE("a stop on the grid, but for rounding, costs no factorisation") {
  const auto run = [](auto&&... observers) {
    Vec y(1, 2);
    PhiStepper stepper{y, decay, trapezoidal};
    return integrate(stepper, y, {0, 10}, fixed(0.1), observers...).statistics;
  };
  std::vector<double> times;
  for (int k = 1; k < 100; ++k) times.push_back(k / 10.0);  // k·0.1 differs in half of them
  int seen = 0;
  const Statistics with = run(at_times(times, [&](double, const Vec&) { ++seen; })), without = run();
  CHECK(seen == 99);
  CHECK(with.steps == without.steps);
  CHECK(with.factorizations == without.factorizations);
}

TEST_CASE("stops a rounding apart cost nothing in accuracy") {
  // Slopes by the scheme's own relation, (y⁺ − b)/φΔt, are noise after a step of 1e-16.
  const auto run = [](auto scheme, auto&&... observers) {
    Moving y = Swing::exact(0);
    PhiStepper stepper{y, Swing{}, scheme, mass(Swing::mass)};
    const RunReport report = integrate(stepper, y, {0, 2}, tolerance{.rtol = 1e-5}, observers...);
    CHECK(report);
    return distance(y, Swing::exact(2));
  };
  const auto check = [&](auto scheme) {
    std::vector<double> times;
    for (int k = 1; k < 10; ++k)
      for (double t = 0.2 * k, n = 0; n < 3; ++n, t = std::nextafter(t, 3)) times.push_back(t);
    for (int k = 0; k < 10; ++k) times.push_back(0.1 + 0.2 * k), times.push_back(0.1 + 0.2 * k + 1e-11);
    const double undisturbed = run(scheme), disturbed = run(scheme, at_times(times, [](double, const auto&) {}));
    CAPTURE(undisturbed, disturbed);
    CHECK(disturbed <= 10 * undisturbed + 1e-5);
  };
  check(trapezoidal), check(backward_euler), check(tr_bdf2), check(velocity_verlet), check(phi(0.7)), check(midpoint);
}

// Edits. Whatever is carried (slopes, Ψ, factors, the estimator's past) must not survive them.
namespace {

/// How far a run whose state is edited at t = 1 is from one that starts there, and the second run's own error.
template <class S>
void check_edits(auto scheme, auto psi, S start, auto&& edit) {
  const tolerance control{.rtol = 1e-5};
  S by_observer = start, by_caller = start, by_finish = start, afresh = start;
  const auto stepper_for = [&](const S& y) { return PhiStepper{y, psi, scheme}; };
  {
    auto stepper = stepper_for(by_observer);
    REQUIRE(integrate(stepper, by_observer, {0, 2}, control, at_times({1.0}, [&](double, S& y) { edit(y); })));
  }
  {
    auto stepper = stepper_for(by_caller);
    auto stop = at_times({1.0}, [](double, const S&) {});
    Run run{stepper, by_caller, {0.0, 2.0}, control, stop};
    while (run.advance())
      if (run.time() == 1) edit(by_caller);
    REQUIRE(run.report());
  }
  {
    // … and the rest in one go, with nobody looking.
    auto stepper = stepper_for(by_finish);
    Run run{stepper, by_finish, {0.0, 2.0}, tolerance{.rtol = 1e-5, .first_step = 0.125 / 64, .max_step = 0.0625}};
    double t = 0;
    for (int n = 0; n < 30; ++n) REQUIRE(run.advance());
    t = run.time();
    edit(by_finish);
    S same = by_finish;
    REQUIRE(run.finish());
    auto other = stepper_for(same);
    REQUIRE(integrate(other, same, {t, 2}, control));
    CHECK(distance(by_finish, same) <= 1e-4);
  }
  {
    auto first = stepper_for(afresh);
    REQUIRE(integrate(first, afresh, {0, 1}, control));
    edit(afresh);
    auto second = stepper_for(afresh);
    REQUIRE(integrate(second, afresh, {1, 2}, control));
  }
  // Both are within about 10·rtol of the truth (tests/tolerance); the edits are of order one.
  CHECK(distance(by_observer, afresh) <= 2e-4);
  CHECK(distance(by_caller, afresh) <= 2e-4);
}

}  // namespace

TEST_CASE("after an edit nothing stale is used") {
  const auto flow = [](const Vec& y, double t) -> Vec { return Vec(-40 * (y[0] - std::cos(t)), y[0] - y[1] * y[1]); };
  const auto swing = [](const Vec& r, const Vec& v, double t) -> Vec {
    return Vec(-9 * r - 0.2 * v + Vec(std::sin(t), 0));
  };
  const auto still = [](const Vec& r) -> Vec { return -9 * r - r.squaredNorm() * r; };
  const auto jump = [](Vec& y) { y = Vec(3, -0.2); };
  const auto bounce = [](Moving& y) { y.r[0] += 1, y.v = -y.v + Vec(0, 2); };
  const auto kick = [](Moving& y) { y.v *= -3; };
  for_each_scheme([&](const char* name, auto scheme) {
    CAPTURE(name);
    if constexpr (!std::is_same_v<decltype(scheme), std::remove_const_t<decltype(forward_euler)>> &&
                  !std::is_same_v<decltype(scheme), std::remove_const_t<decltype(backward_euler)>>) {
      check_edits<Vec>(scheme, flow, Vec(1, 0.5), jump);
      check_edits<Moving>(scheme, swing, Moving{Vec(1, 0), Vec(0, 1)}, bounce);
    }
  });
  check_edits<Moving>(velocity_verlet, swing, Moving{Vec(1, 0), Vec(0, 1)}, bounce);
  check_edits<Moving>(velocity_verlet, still, Moving{Vec(1, 0), Vec(0, 1)}, bounce);
  check_edits<Moving>(velocity_verlet, still, Moving{Vec(1, 0), Vec(0, 1)}, kick);
}

TEST_CASE("an edit costs the force call that makes the slope anew, and no more") {
  const auto calls = [](auto&& edit) {
    Vec y(1, 2);
    PhiStepper stepper{y, decay, forward_euler};
    Run run{stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-3}};
    while (run.advance()) edit(y);
    return run.report().statistics;
  };
  // Two for the first length, one at the end of each try; one at the start of each step whose start isn't known.
  const Statistics kept = calls([](Vec&) {}), edited = calls([](Vec&y) { y[0] = std::nextafter(y[0], 0); });
  CHECK(kept.force_calls == 2 + kept.steps + kept.rejections + 1);
  CHECK(edited.force_calls == 2 + edited.steps + edited.rejections + edited.steps);
}

TEST_CASE("a force that is changed between steps is asked anew") {
  struct Pull {
    double to;
    Vec operator()(const Vec& y) const { return Vec(to - y[0], to - y[1]); }
  };
  for_each_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    Vec y(1, 1);
    PhiStepper stepper{y, Pull{1}, scheme};
    REQUIRE(integrate(stepper, y, {0, 2}, tolerance{.rtol = 1e-4, .max_step = 0.5},
                      at_times({1.0}, [&](double, const Vec&) { stepper.force().to = -5; })));
    CHECK(y[0] == Approx(-5 + 6 * std::exp(-1)).epsilon(1e-3));
  });
}

TEST_CASE("a state that grows while the run goes on") {
  using V = Eigen::VectorXd;
  using Grown = Motion<V>;
  const auto fall = [](const V& r) -> V { return -r; };
  const auto check = [&](auto scheme) {
    Grown y{V::Ones(2), V::Zero(2)};
    PhiStepper stepper{y, fall, scheme};
    const RunReport report =
        integrate(stepper, y, {0, 2}, tolerance{.rtol = 1e-4}, at_times({0.5, 1.0}, [&](double t, Grown& s) {
                    const Index n = s.r.size() + (t < 0.7 ? 40 : -41);
                    s.r = V::Constant(n, std::cos(t)), s.v = V::Constant(n, -std::sin(t));
                  }));
    REQUIRE(report);
    REQUIRE(y.r.size() == 1);
    CHECK(y.r[0] == Approx(std::cos(2.0)).margin(1e-3));
    // A tolerance for each component is then no longer one.
    Grown z{V::Ones(2), V::Zero(2)};
    const RunReport refused = integrate(stepper, z, {0, 2}, tolerance{.rtol = 1e-4, .atol = V(V::Constant(4, 1e-6))},
                                        at_times({0.5}, [&](double, Grown& s) { s.r = s.v = V::Ones(3); }));
    CHECK(refused.outcome == Outcome::invalid_tolerance);
    CHECK(refused.t == 0.5);
  };
  check(trapezoidal), check(tr_bdf2), check(velocity_verlet), check(midpoint);
}

TEST_CASE("observers that stop a controlled run, of both kinds, in order") {
  Vec y = decayed(0);
  PhiStepper stepper{y, decay, trapezoidal};
  std::string order;
  double last = 0;
  const RunReport report = integrate(
      stepper, y, {0, 1}, tolerance{.rtol = 1e-3}, [&](double, const Vec&) { order += 'a'; },
      [&](const CompletedStep<Vec>& step) {
        order += 'b';
        CHECK(step.t0() == last);
        last = step.t1();
        CHECK(step.end() == y);
        return order.size() < 9;
      },
      [&](double, const Vec&) { order += 'c'; });
  CHECK(order == "acabcabcab");
  CHECK(report.outcome == Outcome::stopped_by_observer);
  CHECK(report.t == last);
}

TEST_CASE("dense output through a controlled run: order 4 for y, 6 for the positions of a motion") {
  // Steps of about one length (max_step rules), of a scheme so accurate that interpolation errors alone would show: the
  // interpolant's own ends are compared with it.
  const auto worst = [](double dt) {
    // What lies between the ends, against a run with 8 times as many steps, which has the same error at the ends up to
    // a factor that doesn't matter: both errors are O(Δt²) of a smooth function, its interpolation error is what kinks.
    Vec y = Flow::exact(0);
    PhiStepper stepper{y, Flow{}, tr_bdf2, capacity(Flow::capacity)};
    double off = 0;
    REQUIRE(integrate(stepper, y, {0, 2}, tolerance{.rtol = 0.5, .atol = 1e3, .first_step = dt, .max_step = dt},
                      [&](const auto& step) {
                        for (const double x : {0.25, 0.5, 0.75}) {
                          const double t = step.t0() + x * step.dt();
                          // errors at both ends, carried over linearly
                          const Vec e0 = step.start() - Flow::exact(step.t0()),
                                    e1 = step.end() - Flow::exact(step.t1());
                          off = std::max(off, (step.at(t) - Flow::exact(t) - (1 - x) * e0 - x * e1).norm());
                        }
                      }));
    return off;
  };
  const double a = worst(0.1), b = worst(0.05);
  CAPTURE(a, b);
  CHECK(std::log2(a / b) > 2.7);  // slopes of a solution of order 2, off by O(Δt²), times Δt: order 3 at least
}

TEST_CASE("views of the user's own memory, controlled") {
  double memory[4] = {1, 2, 0, 1}, r2[2] = {1, 2}, v2[2] = {0, 1};
  Motion<Eigen::Map<Vec>> mapped{Eigen::Map<Vec>(memory), Eigen::Map<Vec>(memory + 2)};
  Moving owned{Vec(r2[0], r2[1]), Vec(v2[0], v2[1])};
  const auto spring = [](const Vec& r) -> Vec { return -9 * r - r.squaredNorm() * r; };
  const auto both = [&](auto scheme) {
    PhiStepper a{mapped, spring, scheme}, b{owned, spring, scheme};
    const RunReport one = integrate(a, mapped, {0, 1}, tolerance{.rtol = 1e-4});
    const RunReport two = integrate(b, owned, {0, 1}, tolerance{.rtol = 1e-4});
    REQUIRE(one);
    CHECK(one.statistics == two.statistics);
    CHECK((mapped.r == owned.r && mapped.v == owned.v));
  };
  both(trapezoidal), both(velocity_verlet), both(midpoint), both(tr_bdf2);
  Eigen::VectorXd home = Eigen::VectorXd::Ones(3);
  Eigen::Ref<Eigen::VectorXd> ref(home);
  PhiStepper stepper{ref, [](const Eigen::VectorXd& y) -> Eigen::VectorXd { return -y; }, tr_bdf2};
  CHECK(integrate(stepper, ref, {0, 1}, tolerance{.rtol = 1e-5}));
  CHECK(home[2] == Approx(std::exp(-1)).epsilon(1e-4));
}

TEMPLATE_TEST_CASE("every scalar, controlled", "", float, double, long double) {
  using T = TestType;
  using F = problems::ForcedFlow<T>;
  using M = problems::ForcedMotion<T>;
  const double rtol = sizeof(T) == 4 ? 1e-3 : 1e-6;
  const auto flow = [&](auto scheme) {
    auto y = F::exact(0);
    PhiStepper stepper{y, F{}, scheme, capacity(T(F::capacity))};
    const RunReport report = integrate(stepper, y, {T(0), T(2)}, tolerance{.rtol = rtol});
    REQUIRE(report);
    CHECK(distance(y, F::exact(2)) <= 10 * rtol);
  };
  flow(trapezoidal), flow(tr_bdf2), flow(midpoint);
  const auto motion = [&](auto scheme) {
    auto y = M::exact(0);
    PhiStepper stepper{y, M{}, scheme, mass(T(M::mass))};
    REQUIRE(integrate(stepper, y, {T(0), T(2)}, tolerance{.rtol = rtol}));
    CHECK(distance(y, M::exact(2)) <= 10 * rtol);
  };
  motion(trapezoidal), motion(velocity_verlet);
}

TEST_CASE("one particle that needs short steps rules them in the particle norm") {
  using Columns = Eigen::Matrix3Xd;
  const Index n = 2000;
  const auto force = [](const Columns& r) -> Columns {
    Columns f = -r;
    f.col(1234) *= 400;  // ω = 20
    return f;
  };
  const auto run = [&](Norm norm) {
    Motion<Columns> y{Columns::Ones(3, n), Columns::Zero(3, n)};
    PhiStepper stepper{y, force, velocity_verlet};
    const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-3, .norm = norm});
    REQUIRE(report);
    return std::pair{report, std::abs(y.r(1, 1234) - std::cos(20.0))};
  };
  const auto [mean, poor] = run(Norm::rms);
  const auto [each, good] = run(Norm::particle);
  // rms dilutes it by √2000 = 45.
  CHECK(each.statistics.steps > 2 * mean.statistics.steps);
  CHECK(good <= 0.02);
  CHECK(each.limits.most().by == LimitedBy::error);
  CHECK(each.limits.most().where.index / 3 == 1234);
  std::ostringstream out;
  out << each;
  CHECK_THAT(out.str(), contains("dt limited by       the error of component 37") && contains("of block") &&
                            contains("% of the steps"));
}

TEST_CASE("steps and rejections of the report are those of the run, whoever estimates") {
  for_each_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    Vec y = Flow::exact(0);
    PhiStepper stepper{y, Flow{}, scheme, capacity(Flow::capacity)};
    Run run{stepper, y, {0.0, 2.0}, tolerance{.rtol = 1e-3, .first_step = 1}};
    std::int64_t steps = 0;
    while (run.advance()) ++steps;
    const RunReport report = run.report();
    CHECK(report.statistics.steps == steps);
    CHECK(report.statistics.rejections >= 1);
    CHECK(report.limits.steps() == steps);
  });
}
