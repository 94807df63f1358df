// Without an atol of the user's: components of one vector whose sizes differ by decades, and components that are nothing but
// the errors of others.
#include <phistep/phistep.hpp>
#include <phistep/schemes/radau/radau.hpp>

#include <cmath>
#include <sstream>
#include <string>

#include "problems/hires.hpp"
#include "problems/relaxation.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;

namespace {

using Vec = Eigen::VectorXd;
/// One type of force and one of state, so that each scheme is compiled once.
using Force = shared_force::OfStateAndTime<Vec>;
template <class Problem>
Force force_of(const Problem& problem) {
  return [problem](const Vec& y, double) -> Vec { return problem(typename Problem::State{y}); };
}

struct Outcomes {
  double error;
  std::int64_t tries;
};
/// @param size  the largest magnitudes of the components, relative to which errors are measured
Outcomes run(const Force& force, auto scheme, Vec y, double end, const Vec& exact, const Vec& size, double rtol) {
  PhiStepper stepper{y, force, scheme};
  const RunReport report = integrate(stepper, y, {0, end}, tolerance{.rtol = rtol, .max_steps = 100'000});
  CAPTURE(report.message());
  REQUIRE(report);
  return {((y - exact).array() / size.array()).abs().maxCoeff(),
          report.statistics.steps + report.statistics.rejections};
}

/// The relaxation oscillation with μ = 1000: y = (x, x'), x = 2 … −2, x' up to 1300 in the jumps.
struct Slow {
  using State = Eigen::Vector2d;
  State operator()(const State& y) const { return {y[1], 1e3 * (1 - y[0] * y[0]) * y[1] - y[0]}; }
};
/// y₃' = −1000 (y₃ − (y₁² + y₂² − 1)) on a circle: 0 but for the errors of y₁ and y₂.
struct Difference {
  using State = Eigen::Vector3d;
  State operator()(const State& y) const { return {-y[1], y[0], -1e3 * (y[2] - (y[0] * y[0] + y[1] * y[1] - 1))}; }
};

void check_wide(const char* name, const Force& force, const Vec& start, double end, const Vec& exact, const Vec& size,
                double kappa) {
  for (const double rtol : {1e-3, 1e-4, 1e-6}) {
    CAPTURE(name, rtol);
    CHECK(run(force, rodas4, start, end, exact, size, rtol).error < 10 * kappa * rtol);
    CHECK(run(force, rodas5p, start, end, exact, size, rtol).error < 10 * kappa * rtol);
    CHECK(run(force, radau, start, end, exact, size, rtol).error < 10 * kappa * rtol);
  }
}

}  // namespace

TEST_CASE("van der Pol: x = 2 beside x' = 1e3 and 1e6 in one vector, no atol given") {
  // x(2000) by Radau IIA at rtol 1e-14 and the slow branch's x' = x/(μ(1 − x²)).
  const Eigen::Vector2d slow(1.706167732170469, -8.928097010248125e-4);
  check_wide("mu = 1e3", force_of(Slow{}), Vec{{2.0, 0.0}}, 2000, slow, Vec{{2.0, 1300.0}}, 2.3);
  using P = problems::Relaxation;
  check_wide("mu = 1e6", force_of(P{}), P::start(), P::end, P::exact(), Vec{{2.0, 1.3e6}}, 2.3);
}

TEST_CASE("HIRES: seven components of 1e-2 to 1 beside one that starts at 0.0057, no atol given") {
  using P = problems::Hires;
  P::State size;
  size << 1, 0.15, 0.02, 0.4, 0.03, 0.25, 0.0057, 0.0057;
  const P::State start = P::start(), exact = P::exact();
  for (const double rtol : {1e-4, 1e-6}) {
    CHECK(run(force_of(P{}), rodas4, start, P::end, exact, size, rtol).error < 10 * rtol);
    CHECK(run(force_of(P{}), rodas5p, start, P::end, exact, size, rtol).error < 10 * rtol);
  }
}

TEST_CASE(
    "a component made of the errors of others forces no tiny steps: less than five times those of an atol given") {
  const Eigen::Vector3d start(1, 0, 0), exact(std::cos(20.0), std::sin(20.0), 0), size(1, 1, 1);
  for (const double rtol : {1e-4, 1e-6}) {
    Vec y = start;
    const Force difference = force_of(Difference{});
    PhiStepper stepper{y, difference, rodas5p};
    const RunReport given = integrate(stepper, y, {0, 20}, tolerance{.rtol = rtol, .atol = rtol});
    REQUIRE(given);
    const Outcomes got = run(difference, rodas5p, start, 20, exact, size, rtol);
    CHECK(got.error < 10 * rtol);
    CHECK(got.tries < 5 * given.statistics.steps);
  }
}

// The last component is 0 but for what errors of the others make of it, in a step or in all, or for rounding. It may be off by
// some of these errors; the others by none of its.
TEST_CASE("components that are only errors of others, or rounding: as right and about as quick as with an atol") {
  struct Case {
    const char* name;
    Force force;
    Vec start, exact, size;
    double end;
  };
  const double c = std::cos(20.0), s = std::sin(20.0);
  const auto circle = [&](const char* name, auto rate, double size = 1) {
    const Force force = [rate](const Vec& y, double t) -> Vec { return Vec{{-y[1], y[0], rate(y, t)}}; };
    return Case{name, force, Vec{{1, 0, 0}}, Vec{{c, s, 0}}, Vec{{1, 1, size}}, 20};
  };
  const auto off = [](const Vec& y) { return y[0] * y[0] + y[1] * y[1] - 1; };
  const Case cases[]{
      circle("stiff", [off](const Vec& y, double) { return -1e3 * (y[2] - off(y)); }),
      circle("slow", [off](const Vec& y, double) { return off(y) - y[2]; }),
      circle("an integral", [off](const Vec& y, double) { return off(y); }),
      circle(
          "in other units", [off](const Vec& y, double) { return -1e3 * (y[2] - 1e-12 * off(y)); }, 1e-12),
      circle("beside what it should be", [](const Vec& y, double t) { return -50 * (y[2] - y[0] + std::cos(t)); }),
      {"of twins",
       [](const Vec& y, double) -> Vec {
         return Vec{{-y[1], y[0], -y[3], y[2], -10 * (y[4] - y[0] + y[2])}};
       },
       Vec{{1, 0, 1, 0, 0}}, Vec{{c, s, c, s, 0}}, Vec::Ones(5), 20}};
  const auto check = [&](const char* scheme_name, auto scheme, double rtol) {
    for (const Case& one : cases) {
      CAPTURE(scheme_name, one.name, rtol);
      Vec y = one.start;
      PhiStepper stepper{y, one.force, scheme};
      const RunReport given =
          integrate(stepper, y, {0, one.end}, tolerance{.rtol = rtol, .atol = Vec(rtol * one.size)});
      REQUIRE(given);
      const Outcomes got = run(one.force, scheme, one.start, one.end, one.exact, one.size, rtol);
      CHECK(got.error < 30 * rtol);
      CHECK(got.tries < 7 * given.statistics.steps + 20);
    }
  };
  for (const double rtol : {1e-2, 1e-4, 1e-6}) {
    check("rodas4", rodas4, rtol);
    check("rodas5p", rodas5p, rtol);
    if (rtol < 1e-2) check("radau", radau, rtol);  // its few long steps meet 1e-2 late
    if (rtol < 1e-2) check("tsit5", tsit5, rtol);  // explicit schemes ask in good steps alone, a while later
    check("dop853", dop853, rtol);
  }
  // The sum of Robertson's rates, which cancels to rounding.
  const Force sum = [](const Vec& y, double) -> Vec {
    const double a = 0.04 * y[0], b = 1e4 * y[1] * y[2], d = 3e7 * y[1] * y[1];
    return Vec{{-a + b, a - b - d, d, (-a + b) + (a - b - d) + d}};
  };
  const Vec start{{1, 0, 0, 0}}, end{{0.7158270687194, 9.185534764557e-6, 0.2841637457458, 0}}, size{{1, 4e-5, 1, 1}};
  for (const double rtol : {1e-2, 1e-4, 1e-6}) CHECK(run(sum, rodas5p, start, 40, end, size, rtol).error < 10 * rtol);
  for (const double rtol : {1e-2, 1e-4, 1e-6}) CHECK(run(sum, rodas5p, start, 40, end, size, rtol).tries < 400);
}

// y₃ follows 1e-9 y₁²: small, and stiff, and not an error of y₁.
TEST_CASE("a component that is small has its own digits: the others' errors don't loosen it") {
  const Force small = [](const Vec& y, double) -> Vec {
    return Vec{{-0.5 * y[0], -y[1], -1e4 * (y[2] - 1e-9 * y[0] * y[0])}};
  };
  const Vec start{{1, 1, 1e-9}}, exact{{std::exp(-1.0), std::exp(-2.0), 1e-9 * std::exp(-2.0) / (1 - 1e-4)}};
  for (const double rtol : {1e-2, 1e-4, 1e-6}) {
    CHECK(run(small, rodas4, start, 2, exact, exact, rtol).error < 10 * rtol);
    CHECK(run(small, rodas5p, start, 2, exact, exact, rtol).error < 10 * rtol);
    CHECK(run(small, radau, start, 2, exact, exact, rtol).error < 10 * rtol);
  }
}

TEST_CASE("automatic atol: a pulse that grows out of zero through subnormal numbers") {
  // y' = exp(−50 (t − 5)²), y(0) = 0: y(10) = √(π/50), and less than 1e-308 until t = 1.2
  const Force pulse = [](const Vec&, double t) -> Vec { return Vec::Constant(1, std::exp(-50 * (t - 5) * (t - 5))); };
  const auto run = [&pulse](const auto& scheme) {
    Vec y = Vec::Zero(1);
    PhiStepper stepper{y, pulse, scheme};
    const RunReport report =
        integrate(stepper, y, {0, 10}, tolerance{.rtol = 1e-4, .max_step = 0.1, .max_steps = 20000});
    CAPTURE(report.message());
    CHECK(report);
    CHECK(y[0] == Approx(std::sqrt(std::acos(-1.0) / 50)).epsilon(1e-3));
  };
  run(dop853);
  run(tsit5);
  run(rodas5p);
}

TEST_CASE("a field in a vector, zero in the middle but for rounding: every scheme gets through, and right") {
  // sin 2πx at 41 points: −1.2e-16 in the middle, −2.4e-16 at the end.
  constexpr int n = 40;
  const double pi = std::acos(-1.0), rate = 4.0 * n * n * std::pow(std::sin(pi / n), 2);
  const Vec start = (2 * pi * Vec::LinSpaced(n + 1, 0, 1).array()).sin();
  const auto laplacian = [](const Vec& u) {
    Vec d = Vec::Zero(n + 1);
    for (int i = 1; i < n; ++i) d[i] = n * n * (u[i - 1] - 2 * u[i] + u[i + 1]);
    return d;
  };
  const Force conducts = [laplacian](const Vec& u, double) -> Vec { return laplacian(u); };
  const auto heat = [&](const char* name, const auto& scheme) {
    for (const double rtol : {1e-3, 1e-6}) {
      CAPTURE(name, rtol);
      const Outcomes got = run(conducts, scheme, start, 0.1, start * std::exp(-0.1 * rate), Vec::Ones(n + 1), rtol);
      CHECK(got.error < 10 * rtol);
      CHECK(got.tries < 3000);
    }
  };
  heat("radau", radau);
  heat("rodas5p", rodas5p);
  heat("tr_bdf2", tr_bdf2);
  heat("dop853", dop853);
  const auto wave = [&](const char* name, const auto& scheme) {
    for (const double rtol : {1e-3, 1e-6}) {
      CAPTURE(name, rtol);
      Motion<Vec> string{start, Vec(Vec::Zero(n + 1))};
      PhiStepper stepper{string, [laplacian](const Vec& r) -> Vec { return laplacian(r); }, scheme};
      const RunReport report = integrate(stepper, string, {0, 3}, tolerance{.rtol = rtol, .max_steps = 3000});
      CAPTURE(report.message());
      CHECK(report);
      CHECK((string.r - start * std::cos(3 * std::sqrt(rate))).cwiseAbs().maxCoeff() < 10 * rtol);
    }
  };
  wave("radau", radau);
  wave("rkn86", rkn86);
  wave("dop853", dop853);
}

TEST_CASE("a settled body costs next to nothing, also where the run is one of many, or begins at rest") {
  const auto spring = [](const Vec& r, const Vec& v) -> Vec { return Vec::Constant(1, 9.81) - 400 * r - 4 * v; };
  const auto tries_of = [](auto& stepper, auto& body, double from, double to) {
    const RunReport report = integrate(stepper, body, {from, to}, tolerance{.rtol = 1e-6, .max_steps = 20'000});
    REQUIRE(report);
    return report.statistics.steps + report.statistics.rejections + report.statistics.failed_steps;
  };
  const auto settle = [&](const char* name, const auto& scheme) {
    CAPTURE(name);
    Motion<Vec> body{Vec(Vec::Zero(1)), Vec(Vec::Zero(1))};
    PhiStepper stepper{body, spring, scheme};
    CHECK(tries_of(stepper, body, 0, 20) < 1500);
    for (const double t : {20.0, 40.0, 100.0}) CHECK(tries_of(stepper, body, t, 2 * t) < 100);
    Motion<Vec> resting{Vec(Vec::Constant(1, 9.81 / 400)), Vec(Vec::Zero(1))};
    resting.r[0] *= 1 + 1e-15;
    PhiStepper anew{resting, spring, scheme};
    CHECK(tries_of(anew, resting, 0, 20) < 200);
  };
  settle("radau", radau);
  settle("rodas5p", rodas5p);
}

TEST_CASE("what a handler makes small is measured by what it is then") {
  // y' = cos t · y beside a constant; at t = 1 y is divided by 1e8.
  const auto force = [](const Vec& y, double t) -> Vec { return Vec{{std::cos(t) * y[0], 0}}; };
  const auto check = [&](const char* name, const auto& scheme) {
    CAPTURE(name);
    Vec y{{1, 1}};
    PhiStepper stepper{y, force, scheme};
    auto divide = event([](double t, const Vec&) { return t - 1; }, {}, [](double, Vec& state) { state[0] *= 1e-8; });
    REQUIRE(integrate(stepper, y, {0, 10}, tolerance{.rtol = 1e-5}, divide));
    CHECK(y[0] == Approx(1e-8 * std::exp(std::sin(10.0))).epsilon(1e-4).margin(0));
  };
  check("dop853", dop853);
  check("rodas5p", rodas5p);
}

TEST_CASE("the report says that no atol was given, and of which component fewer digits were asked") {
  const auto decay = [](const Vec& y) -> Vec { return Vec{{-y[0], 0 * y[1]}}; };
  Vec y{{1, 1}};
  PhiStepper stepper{y, decay, dop853};
  const RunReport alone = integrate(stepper, y, {0, 100}, tolerance{.rtol = 1e-6});
  REQUIRE(alone);
  CHECK(alone.limits.has_own_scales);
  CHECK(alone.limits.below.where() == Component{0, 0});
  CHECK(alone.limits.below.steps() > alone.limits.steps() / 4);  // below 1e-9 from t = 20 on
  std::ostringstream text;
  text << alone;
  CHECK(text.str().find("atol                none given: component 0 of block 0") != std::string::npos);

  const RunReport given = integrate(stepper, y, {100, 101}, tolerance{.rtol = 1e-6, .atol = 1e-6});
  CHECK_FALSE(given.limits.has_own_scales);
  CHECK(given.message().find("More tries failed") == std::string::npos);

  RunReport odd = alone;
  odd.statistics.rejections = 5000;
  CHECK(odd.message().find("More tries failed (5000) than steps were done") != std::string::npos);
  odd.limits.leapt.name({0, 1});
  CHECK(odd.message().find("grew more than a thousandfold: component 1 of block 0") != std::string::npos);
}
