// Forces that are NaN beyond a bound, under explicit schemes. The members are those of force_bounds.hpp.
#include "failure/force_bounds.hpp"

using namespace force_bounds;

// Counts that may flip with a rounding have some room.
#if PHISTEP_STRESS
constexpr int members = 600, known_touching = 0, known_blind = 0;
#elif PHISTEP_FULL
constexpr int members = 90, known_touching = 0, known_blind = 0;
#endif

namespace {

const Batteries& bounds() {
  static const Batteries all{"force bounds, explicit",
                             {
                                 subject<Flow>("forward_euler", forward_euler, 3, false),
                                 subject<Flow>("tsit5", tsit5, 9, false),
                                 subject<Flow>("dop853", dop853, 9, false),
                             },
                             members};
  return all;
}

}  // namespace

TEST_CASE("force bounds, explicit, touched under a tolerance: no more are wrong than known") {
  battery::at_most(known_touching, bounds().touching());
}
TEST_CASE("force bounds, explicit, touched under a tolerance: none is wrong", "[!shouldfail][48]") {
  battery::none(bounds().touching());
}

TEST_CASE("force bounds, explicit, inside under a tolerance: none is wrong") { battery::at_most(0, bounds().inside()); }

TEST_CASE("force bounds, explicit, fixed steps: no more are wrong than known") {
  battery::at_most(known_blind, bounds().blind_steps());
}
TEST_CASE("force bounds, explicit, fixed steps: none is wrong", "[!shouldfail][48]") {
  battery::none(bounds().blind_steps());
}
