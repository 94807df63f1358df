// Jumps of a force on a motion at times that the user knows, under a tolerance: as right, and as few steps, as without.
#include "accuracy/jumps_cases.hpp"
#include "support/catch.hpp"

constexpr int members = 200;

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
  jumps::are_right(answers<Way::handler_resets>());
}
TEST_CASE("jumps, tolerance, motion: right where steps end on the jumps") {
  jumps::are_right(answers<Way::at_times>());
}
TEST_CASE("jumps, tolerance, motion: right where a run ends on each jump") {
  jumps::are_right(answers<Way::row_of_runs>());
}
TEST_CASE("jumps, tolerance, motion: right where at_times switches the load") {
  jumps::are_right(answers<Way::handler>());
}
