// Jumps of a load at times that the user knows, at a fixed Δt: every scheme keeps its order.
#include "accuracy/jumps_cases.hpp"
#include "support/catch.hpp"

// Beside each number a few more are let pass: rounding decides some members.
#if PHISTEP_STRESS
constexpr int members = 100, known_observer = 202;
#elif PHISTEP_FULL
constexpr int members = 20, known_observer = 42;
#endif

using jumps::Way;

namespace {

template <Way way>
const battery::Tally& tally() {
  static const battery::Tally counted = [] {
    battery::Tally tally{"jumps, fixed steps, " + jumps::name(way)};
    for (int number = 0; number < members; ++number) {
      const auto each = [&](const char* name, auto scheme, double order, int steps, double unit = 1) {
        jumps::order_survives<jumps::Turning>(tally, number, way, name, scheme, order, steps, unit);
      };
      each("tsit5", phistep::tsit5, 5, 4);
      each("dop853", phistep::dop853, 8, 1);
      each("rodas5p", phistep::rodas5p, 5, 4);
      each("radau", phistep::radau, 5, 2);
      each("tr_bdf2", phistep::tr_bdf2, 2, 10);
      each("generalized_alpha(0.5)", phistep::generalized_alpha(0.5), 2, 10);
      each("trapezoidal", phistep::trapezoidal, 2, 10);
      each("midpoint", phistep::midpoint, 2, 10);
      each("phi(0.7)", phistep::phi(0.7), 1, 40);
    }
    return tally;
  }();
  return counted;
}

}  // namespace

TEST_CASE("jumps, fixed steps: right where the steppers are new or told") {
  battery::at_most(0, tally<Way::pieces>());
  battery::at_most(0, tally<Way::handler_resets>());
  battery::at_most(0, tally<Way::observer_resets>());
}
TEST_CASE("jumps, fixed steps: right where steps end on the jumps") { battery::at_most(0, tally<Way::at_times>()); }
TEST_CASE("jumps, fixed steps: right where a run ends on each jump") { battery::at_most(0, tally<Way::row_of_runs>()); }
TEST_CASE("jumps, fixed steps: right where at_times switches the load") { battery::at_most(0, tally<Way::handler>()); }

// What looks at each step is not taken to switch a load: that would cost a second force call a step wherever one looks.
TEST_CASE("jumps, fixed steps, an observer switches the load: no more are wrong than known") {
  battery::at_most(known_observer, tally<Way::observer>());
}
TEST_CASE("jumps, fixed steps, an observer switches the load: none is wrong", "[!shouldfail][48]") {
  battery::none(tally<Way::observer>());
}
