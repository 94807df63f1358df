// Jumps of a load at times that the user knows, under a tolerance: as right, and as few steps, as without jumps.
#include "accuracy/jumps_cases.hpp"
#include "support/catch.hpp"

#if PHISTEP_STRESS
constexpr int members = 200;
#elif PHISTEP_FULL
constexpr int members = 100;
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
  jumps::are_right(answers<Way::handler_resets>());
}
TEST_CASE("jumps, tolerance: right where steps end on the jumps") { jumps::are_right(answers<Way::at_times>()); }
TEST_CASE("jumps, tolerance: right where a run ends on each jump") { jumps::are_right(answers<Way::row_of_runs>()); }
TEST_CASE("jumps, tolerance: right where at_times switches the load") { jumps::are_right(answers<Way::handler>()); }
