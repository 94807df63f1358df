// Jumps of a force on a motion at times that the user knows, at a fixed Δt: every scheme keeps its order.
#include "accuracy/jumps_cases.hpp"
#include "support/catch.hpp"

// Beside each number a few more are let pass: rounding decides some members.
#if PHISTEP_STRESS
constexpr int members = 100, known_observer = 508;
#elif PHISTEP_FULL
constexpr int members = 20, known_observer = 102;
#endif

using jumps::Way;

namespace {

template <Way way>
const battery::Tally& tally() {
  static const battery::Tally counted = [] {
    battery::Tally tally{"jumps, fixed steps, motion, " + jumps::name(way)};
    for (int number = 0; number < members; ++number) {
      const auto each = [&](const char* name, auto scheme, double order, int steps, double unit = 1) {
        jumps::order_survives<jumps::Swinging>(tally, number, way, name, scheme, order, steps, unit);
      };
      each("velocity_verlet", phistep::velocity_verlet, 2, 10);
      each("srkn6b", phistep::srkn6b, 4, 4);
      each("rkn86", phistep::rkn86, 8, 1, 1.5);
      each("rkn1210", phistep::rkn1210, 12, 1, 3);
      each("tr_bdf2", phistep::tr_bdf2, 2, 10);
      each("generalized_alpha(0.5)", phistep::generalized_alpha(0.5), 2, 10);
      each("trapezoidal", phistep::trapezoidal, 2, 10);
    }
    return tally;
  }();
  return counted;
}

}  // namespace

TEST_CASE("jumps, fixed steps, motion: right where the steppers are new or told") {
  battery::at_most(0, tally<Way::pieces>());
  battery::at_most(0, tally<Way::handler_resets>());
  battery::at_most(0, tally<Way::observer_resets>());
}
TEST_CASE("jumps, fixed steps, motion: right where steps end on the jumps") {
  battery::at_most(0, tally<Way::at_times>());
}
TEST_CASE("jumps, fixed steps, motion: right where a run ends on each jump") {
  battery::at_most(0, tally<Way::row_of_runs>());
}
TEST_CASE("jumps, fixed steps, motion: right where at_times switches the load") {
  battery::at_most(0, tally<Way::handler>());
}

// What looks at each step is not taken to switch a load: that would cost a second force call a step wherever one looks.
TEST_CASE("jumps, fixed steps, motion, an observer switches the load: no more are wrong than known") {
  battery::at_most(known_observer, tally<Way::observer>());
}
TEST_CASE("jumps, fixed steps, motion, an observer switches the load: none is wrong", "[!shouldfail][48]") {
  battery::none(tally<Way::observer>());
}
