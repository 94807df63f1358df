// Jumps of a load at times that the user knows, under a tolerance: as right, and as few steps, as without jumps.
#include "accuracy/jumps_cases.hpp"
#include "support/catch.hpp"

// Beside each number a few more are let pass: rounding decides some members.
#if PHISTEP_STRESS
constexpr int members = 200;
constexpr int known_at_times_errors = 45, known_at_times_tries = 735, known_row_of_runs_errors = 57,
              known_row_of_runs_tries = 739, known_handler_errors = 33, known_handler_tries = 263;
#elif PHISTEP_FULL
constexpr int members = 100;
constexpr int known_at_times_errors = 19, known_at_times_tries = 379, known_row_of_runs_errors = 28,
              known_row_of_runs_tries = 379, known_handler_errors = 15, known_handler_tries = 140;
#endif

using jumps::Way;

namespace {

template <Way way>
const jumps::Answers& answers() {
  static const jumps::Answers counted = [] {
    const std::string name = "jumps, tolerance, " + jumps::name(way);
    jumps::Answers of{{name}, {name + ", steps"}};
    for (int number = 0; number < members; ++number) {
      const auto each = [&](const char* who, auto scheme, double tightest) {
        jumps::tolerance_holds<jumps::Turning>(of, number, way, who, scheme, tightest);
      };
      each("tsit5", phistep::tsit5, -9);
      each("dop853", phistep::dop853, -11);
      each("rodas5p", phistep::rodas5p, -8);
      each("radau", phistep::radau, -10);
      each("tr_bdf2", phistep::tr_bdf2, -6);
    }
    return of;
  }();
  return counted;
}

}  // namespace

TEST_CASE("jumps, tolerance: right where the steppers are new or told") {
  battery::at_most(0, answers<Way::pieces>().errors);
  battery::at_most(0, answers<Way::handler_resets>().errors);
  battery::at_most(0, answers<Way::handler_resets>().tries);
}
TEST_CASE("jumps, tolerance, steps end on the jumps: no more are wrong than known") {
  battery::at_most(known_at_times_errors, answers<Way::at_times>().errors);
}
TEST_CASE("jumps, tolerance, steps end on the jumps: none is wrong", "[!shouldfail][48]") {
  battery::none(answers<Way::at_times>().errors);
}

TEST_CASE("jumps, tolerance, steps end on the jumps, steps: no more are wrong than known") {
  battery::at_most(known_at_times_tries, answers<Way::at_times>().tries);
}
TEST_CASE("jumps, tolerance, steps end on the jumps, steps: none is wrong", "[!shouldfail][48]") {
  battery::none(answers<Way::at_times>().tries);
}

TEST_CASE("jumps, tolerance, a run ends on each jump: no more are wrong than known") {
  battery::at_most(known_row_of_runs_errors, answers<Way::row_of_runs>().errors);
}
TEST_CASE("jumps, tolerance, a run ends on each jump: none is wrong", "[!shouldfail][48]") {
  battery::none(answers<Way::row_of_runs>().errors);
}

TEST_CASE("jumps, tolerance, a run ends on each jump, steps: no more are wrong than known") {
  battery::at_most(known_row_of_runs_tries, answers<Way::row_of_runs>().tries);
}
TEST_CASE("jumps, tolerance, a run ends on each jump, steps: none is wrong", "[!shouldfail][48]") {
  battery::none(answers<Way::row_of_runs>().tries);
}

TEST_CASE("jumps, tolerance, at_times switches the load: no more are wrong than known") {
  battery::at_most(known_handler_errors, answers<Way::handler>().errors);
}
TEST_CASE("jumps, tolerance, at_times switches the load: none is wrong", "[!shouldfail][48]") {
  battery::none(answers<Way::handler>().errors);
}

TEST_CASE("jumps, tolerance, at_times switches the load, steps: no more are wrong than known") {
  battery::at_most(known_handler_tries, answers<Way::handler>().tries);
}
TEST_CASE("jumps, tolerance, at_times switches the load, steps: none is wrong", "[!shouldfail][48]") {
  battery::none(answers<Way::handler>().tries);
}
