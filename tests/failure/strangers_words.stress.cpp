// Programs as users write them that can't end well, or only at a great cost: what the library says of them. Right is a result
// that keeps what was asked for, or words that name the cause.
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;

namespace {

using One = Eigen::Vector<double, 1>;
using Two = Eigen::Vector2d;

[[nodiscard]] bool says(const RunReport& report, const std::string& word) {
  return report.message().find(word) != std::string::npos;
}

// ---- sliding modes: the rate jumps on a line which both sides lead to ----

struct Sliding {
  RunReport report;
  Two y;
};
/// x' = x > y ? −2 : 2, y' = y > x ? −3 : 3/2 from (3/2, 1): they meet at t = 1/7 and go on together at (2 − 20/8.5).
Sliding slide(auto scheme, std::int64_t max_steps) {
  Two y{1.5, 1};
  const shared_force::OfState<Two> rate{[](const Two& u) -> Two {
    return {u[0] > u[1] ? -2.0 : 2.0, u[1] > u[0] ? -3.0 : 1.5};
  }};
  PhiStepper stepper{y, rate, scheme};
  const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-6, .atol = 1e-6, .max_steps = max_steps});
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

}  // namespace

TEST_CASE("a sliding mode under an explicit scheme: many steps, and the right end") {
  const Sliding run = slide(tsit5, 200000);
  const double exact = 1.5 - 2.0 / 7 + (2 - 20 / 8.5) * 6 / 7;
  REQUIRE(run.report);
  CHECK((run.y - Two{exact, exact}).norm() <= 1e-3);
}
TEST_CASE("a sliding mode under tr_bdf2: the message names the chattering") {
  CHECK(ends_or_names_chattering(slide(tr_bdf2, 30000)));
}
TEST_CASE("a sliding mode under radau: the message names the chattering") {
  CHECK(ends_or_names_chattering(slide(radau, 30000)));
}

TEST_CASE("a force that is NaN where the look for an event asks: the force is blamed") {
  CHECK(says(look_into_a_gap(rodas4), "the force is not finite"));
  CHECK(says(look_into_a_gap(forward_euler), "the force is not finite"));
  CHECK(says(look_into_a_gap(trapezoidal), "the force is not finite"));
  CHECK(says(look_into_a_gap(tsit5), "the force is not finite"));
}
TEST_CASE("an oscillation of size 1e-290 keeps rtol 1e-11") {
  for (const double amplitude : {1.0, 1e-150, 1e-290}) CHECK(error_told_as_success(amplitude, 1e-11) <= 1e-10);
}
// A tolerance below the smallest normal number, 2e-308, is taken as that.
TEST_CASE("an oscillation of size 1e-300 keeps what 2e-308 is of it") {
  CHECK(error_told_as_success(1e-300, 1e-6) <= 1e-5);
  CHECK(error_told_as_success(1e-300, 1e-11) <= 1e-6);
}

// ---- algebraic equations that don't contain an unknown of their own ----

TEST_CASE("a pendulum of index 2 or 3: a run that fails says that it may be the index") {
  using Five = Eigen::Vector<double, 5>;
  const auto run = [](auto scheme, bool is_index_3) {
    Five y{1, 0, 0, 0, 0};
    const shared_force::OfState<Five> rate{[is_index_3](const Five& u) -> Five {
      const double x = u[0], z = u[1];
      return {u[2], u[3], -u[4] * x, -u[4] * z - 1, is_index_3 ? x * x + z * z - 1 : x * u[2] + z * u[3]};
    }};
    PhiStepper stepper{y, rate, scheme, capacity(Five{1, 1, 1, 1, 0})};
    const RunReport report = integrate(stepper, y, {0, 2}, tolerance{.rtol = 1e-6, .atol = 1e-6, .max_steps = 20000});
    CAPTURE(is_index_3, report.message());
    CHECK((report || says(report, "index 2 or more")));
    return static_cast<bool>(report);
  };
  for (const bool is_index_3 : {false, true}) {
    CHECK_FALSE(run(radau, is_index_3));
    CHECK_FALSE(run(tr_bdf2, is_index_3));
    CHECK_FALSE(run(backward_euler, is_index_3));
    run(rodas5p, is_index_3);
  }
}
TEST_CASE("Newton that fails beside a regular M says nothing of the index") {
  One y{1};
  PhiStepper stepper{y, shared_force::OfState<One>{[](const One& x) { return x; }}, backward_euler};
  const StepReport report = stepper.step(y, 0, 1);
  CHECK(report.outcome() == Outcome::singular_matrix);
  CHECK(report.message().find("index") == std::string::npos);
}
