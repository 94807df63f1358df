// Programs as users write them that can't end well, or only at a great cost: what the library says of them. Right is a result
// that keeps what was asked for, or words that name the cause.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>

#include "support/catch.hpp"
#include "support/shared_force.hpp"

#if PHISTEP_FULL

using namespace phistep;

namespace {

using One = Eigen::Vector<double, 1>;
using Two = Eigen::Vector2d;
using Four = Eigen::Vector4d;

[[nodiscard]] bool says(const RunReport& report, const std::string& word) {
  return report.message().find(word) != std::string::npos;
}

// ---- sliding modes: the rate jumps on a line which both sides lead to ----

struct Sliding {
  RunReport report;
  Two y;
};
/// x' = x > y ? −2 : 2, y' = y > x ? −3 : 3/2 from (3/2, 1): they meet at t = 1/7 and go on together at (2 − 20/8.5).
Sliding slide(auto scheme) {
  Two y{1.5, 1};
  const shared_force::OfState<Two> rate{[](const Two& u) -> Two {
    return {u[0] > u[1] ? -2.0 : 2.0, u[1] > u[0] ? -3.0 : 1.5};
  }};
  PhiStepper stepper{y, rate, scheme};
  const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-6, .atol = 1e-6, .max_steps = 30000});
  return {report, y};
}
[[nodiscard]] bool ends_or_names_chattering(const Sliding& run) {
  return run.report.outcome == Outcome::success || says(run.report, "chatter");
}

// ---- a force that is NaN where the look for an event asks ----

/// y' = 1, but NaN for 0.51 < y < 0.55; an event at y = 0.53; Δt = 0.1.
RunReport look_into_a_gap(auto scheme) {
  One y{0};
  const shared_force::OfState<One> rate{
      [](const One& x) { return One{x[0] > 0.51 && x[0] < 0.55 ? std::numeric_limits<double>::quiet_NaN() : 1.0}; }};
  PhiStepper stepper{y, rate, scheme};
  auto level = event([](const One& x) { return x[0] - 0.53; });
  return integrate(stepper, y, {0, 1}, fixed(0.1), level);
}

// ---- numbers so small that products of them vanish ----

/// The error of an oscillator of this amplitude after t = 10, relative to it; 0 where the run says that it failed.
double error_told_as_success(double amplitude, double rtol) {
  Two y{amplitude, 0};
  PhiStepper stepper{y, shared_force::OfState<Two>{[](const Two& x) -> Two { return {-x[1], x[0]}; }}, dop853};
  if (!integrate(stepper, y, {0, 10}, tolerance{.rtol = rtol})) return 0;
  return (y / amplitude - Two{std::cos(10.0), std::sin(10.0)}).norm();
}

// ---- a differential-algebraic equation ----

constexpr double period = 6.283185307179586;
/// x' = z, y' = w, 0 = x − y − w, 0 = −x − y − 0.001 z + sin t, from 0.
struct Dae {
  RunReport report;
  Four y = Four::Zero();
};
Dae solve_dae(auto scheme, double rtol) {
  Dae run{};
  const shared_force::OfStateAndTime<Four> rate{[](const Four& u, double t) -> Four {
    return {u[2], u[3], u[0] - u[1] - u[3], -u[0] - u[1] - 1e-3 * u[2] + std::sin(t)};
  }};
  PhiStepper stepper{run.y, rate, scheme, capacity(Four{1, 1, 0, 0})};
  run.report = integrate(stepper, run.y, {0, period}, tolerance{.rtol = rtol, .max_steps = 20000});
  return run;
}
/// The same with z and w put in: two ordinary equations.
Dae solve_ode(auto scheme, double rtol) {
  Dae run{};
  Two y{0, 0};
  const shared_force::OfStateAndTime<Two> rate{[](const Two& u, double t) -> Two {
    return {(-u[0] - u[1] + std::sin(t)) / 1e-3, u[0] - u[1]};
  }};
  PhiStepper stepper{y, rate, scheme};
  run.report = integrate(stepper, y, {0, period}, tolerance{.rtol = rtol, .max_steps = 20000});
  run.y << y[0], y[1], (-y[0] - y[1] + std::sin(period)) / 1e-3, y[0] - y[1];
  return run;
}

// ---- a charge in a magnetic field ----

struct Gyration {
  Outcome outcome;
  double radius, fastest;
};
/// m = 3, q = 1.5, B = 2, v = 2: once round in 2π at the radius 2. A thousand turns.
Gyration gyrate(auto scheme, int steps_a_turn) {
  using Three = Eigen::Vector3d;
  const Three field{0, 0, 2};
  Motion<Three> y{Three{0, 0, 0}, Three{2, 0, 0}};
  const shared_force::OfMotion<Three> lorentz{
      [=](const Three&, const Three& v) -> Three { return 1.5 * v.cross(field); }};
  PhiStepper stepper{y, lorentz, scheme, mass(3.0)};
  double lowest = 0, fastest = 0;
  const auto look = [&](double, const Motion<Three>& at) {
    lowest = std::min(lowest, at.r.y());
    fastest = std::max(fastest, at.v.norm());
  };
  const RunReport report = integrate(stepper, y, {0, 1000 * period}, fixed(period / steps_a_turn), look);
  return {report.outcome, -lowest / 2, fastest};
}

}  // namespace

TEST_CASE("a sliding mode: explicit schemes and rodas5p follow it, many steps to the unit of time") {
  const double exact = 1.5 - 2.0 / 7 + (2 - 20 / 8.5) * 6 / 7;
  const Sliding run = slide(tsit5);
  REQUIRE(run.report.outcome == Outcome::too_many_steps);  // 66,463 steps
  CHECK(std::abs(run.y[0] - run.y[1]) <= 1e-3);
  CHECK(exact == Approx(0.911765).epsilon(1e-6));
}
TEST_CASE("a sliding mode under tr_bdf2: the message names the chattering", "[!shouldfail][47-B]") {
  CHECK(ends_or_names_chattering(slide(tr_bdf2)));
}
TEST_CASE("a sliding mode under radau: the message names the chattering", "[!shouldfail][47-B]") {
  CHECK(ends_or_names_chattering(slide(radau)));
}

TEST_CASE("a force that is NaN where the look for an event asks: the force is blamed") {
  CHECK(says(look_into_a_gap(forward_euler), "the force is not finite"));
  CHECK(says(look_into_a_gap(trapezoidal), "the force is not finite"));
  CHECK(says(look_into_a_gap(tsit5), "the force is not finite"));
}
TEST_CASE("a force that is NaN where the look for an event asks, rodas4: the force is blamed", "[!shouldfail][47-B]") {
  CHECK(says(look_into_a_gap(rodas4), "the force is not finite"));
}

TEST_CASE("an oscillation of size 1e-290 keeps rtol 1e-11") {
  for (const double amplitude : {1.0, 1e-150, 1e-290}) CHECK(error_told_as_success(amplitude, 1e-11) <= 1e-10);
}
TEST_CASE("an oscillation of size 1e-300 keeps rtol 1e-11, or the run says that it can't", "[!shouldfail][47-B]") {
  CHECK(error_told_as_success(1e-300, 1e-11) <= 1e-9);
}
TEST_CASE("an oscillation of size 1e-305 keeps rtol 1e-6, or the run says that it can't", "[!shouldfail][47-B]") {
  CHECK(error_told_as_success(1e-305, 1e-6) <= 1e-4);
}

TEST_CASE("a differential-algebraic equation at rtol 1e-10 and its ordinary form end at one state") {
  const Dae dae = solve_dae(radau, 1e-10), ode = solve_ode(radau, 1e-10), rosenbrock = solve_dae(rodas5p, 1e-10);
  REQUIRE(dae.report);
  REQUIRE(ode.report);
  REQUIRE(rosenbrock.report);
  CHECK((dae.y - ode.y).head(2).norm() <= 1e-8);
  CHECK((rosenbrock.y - ode.y).head(2).norm() <= 1e-8);
  CHECK(dae.report.statistics.steps <= 100);
}
TEST_CASE("rodas5p on a differential-algebraic equation takes few steps more than on its ordinary form",
          "[!shouldfail][47-B]") {
  CHECK(solve_dae(rodas5p, 1e-10).report.statistics.steps <= 3 * solve_ode(rodas5p, 1e-10).report.statistics.steps);
}

TEST_CASE("a charge in a magnetic field keeps its speed under midpoint, and is on a circle of the scheme's radius") {
  for (const int steps : {50, 10}) {
    const Gyration run = gyrate(midpoint, steps);
    CHECK(run.outcome == Outcome::success);
    CHECK(run.fastest == Approx(2).epsilon(1e-9));
    CHECK(run.radius <= 2 * (1 + 1.1 * std::pow(period / 2 / steps, 2)));
  }
}
TEST_CASE("a charge in a magnetic field under symplectic_euler: right, or no success", "[!shouldfail][47-B]") {
  const Gyration run = gyrate(symplectic_euler, 50);
  CHECK((run.outcome != Outcome::success || run.fastest <= 2.1));
}

#endif
