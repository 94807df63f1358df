// Jumps of a force on a motion at times that the user knows, under a tolerance: as right, and as few steps, as without.
#include "accuracy/jumps_cases.hpp"
#include "support/catch.hpp"

// Beside each number a few more are let pass: rounding decides some members.
constexpr int members = 200;
constexpr int known_at_times_errors = 11, known_at_times_tries = 595, known_row_of_runs_errors = 17,
              known_row_of_runs_tries = 591, known_handler_tries = 407;

using jumps::Way;

namespace {

template <Way way>
const jumps::Answers& answers() {
  static const jumps::Answers counted = [] {
    const std::string name = "jumps, tolerance, motion, " + jumps::name(way);
    jumps::Answers of{{name}, {name + ", steps"}};
    for (int number = 0; number < members; ++number) {
      const auto each = [&](const char* who, auto scheme, double tightest) {
        jumps::tolerance_holds<jumps::Swinging>(of, number, way, who, scheme, tightest);
      };
      each("velocity_verlet", phistep::velocity_verlet, -6);
      each("rkn86", phistep::rkn86, -10);
      each("rkn1210", phistep::rkn1210, -11);
      each("rodas5p", phistep::rodas5p, -8);
      each("tr_bdf2", phistep::tr_bdf2, -6);
    }
    return of;
  }();
  return counted;
}

}  // namespace

TEST_CASE("jumps, tolerance, motion: right where the steppers are new or told") {
  battery::at_most(0, answers<Way::pieces>().errors);
  battery::at_most(0, answers<Way::handler_resets>().errors);
  battery::at_most(0, answers<Way::handler_resets>().tries);
  battery::at_most(0, answers<Way::handler>().errors);
}
TEST_CASE("jumps, tolerance, motion, steps end on the jumps: no more are wrong than known") {
  battery::at_most(known_at_times_errors, answers<Way::at_times>().errors);
}
TEST_CASE("jumps, tolerance, motion, steps end on the jumps: none is wrong", "[!shouldfail][48]") {
  battery::none(answers<Way::at_times>().errors);
}

TEST_CASE("jumps, tolerance, motion, steps end on the jumps, steps: no more are wrong than known") {
  battery::at_most(known_at_times_tries, answers<Way::at_times>().tries);
}
TEST_CASE("jumps, tolerance, motion, steps end on the jumps, steps: none is wrong", "[!shouldfail][48]") {
  battery::none(answers<Way::at_times>().tries);
}

TEST_CASE("jumps, tolerance, motion, a run ends on each jump: no more are wrong than known") {
  battery::at_most(known_row_of_runs_errors, answers<Way::row_of_runs>().errors);
}
TEST_CASE("jumps, tolerance, motion, a run ends on each jump: none is wrong", "[!shouldfail][48]") {
  battery::none(answers<Way::row_of_runs>().errors);
}

TEST_CASE("jumps, tolerance, motion, a run ends on each jump, steps: no more are wrong than known") {
  battery::at_most(known_row_of_runs_tries, answers<Way::row_of_runs>().tries);
}
TEST_CASE("jumps, tolerance, motion, a run ends on each jump, steps: none is wrong", "[!shouldfail][48]") {
  battery::none(answers<Way::row_of_runs>().tries);
}

TEST_CASE("jumps, tolerance, motion, at_times switches the load, steps: no more are wrong than known") {
  battery::at_most(known_handler_tries, answers<Way::handler>().tries);
}
TEST_CASE("jumps, tolerance, motion, at_times switches the load, steps: none is wrong", "[!shouldfail][48]") {
  battery::none(answers<Way::handler>().tries);
}
