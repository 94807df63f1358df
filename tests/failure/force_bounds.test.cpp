// Forces that are NaN beyond a bound, under φ-schemes and TR-BDF2. The members are those of force_bounds.hpp.
#include "failure/force_bounds.hpp"

using namespace force_bounds;

// Counts that may flip with a rounding have some room.
#if PHISTEP_STRESS
constexpr int members = 600, known_touching = 14, known_blind = 310;
#elif PHISTEP_FULL
constexpr int members = 90, known_touching = 6, known_blind = 42;
#endif

namespace {

const Batteries& bounds() {
  static const Batteries all{"force bounds, phi-schemes",
                             {
                                 subject<Flow>("trapezoidal", trapezoidal, 4),
                                 subject<Flow>("midpoint", midpoint, 4, false),
                                 subject<Flow>("backward_euler", backward_euler, 3),
                                 subject<Flow>("tr_bdf2", tr_bdf2, 4),
                                 subject<Flow>("generalized_alpha(0.5)", generalized_alpha(0.5), 4),
#if PHISTEP_STRESS
                                 subject<Flow>("phi(0.7)", phi(0.7), 3),
#endif
                             },
                             members};
  return all;
}

}  // namespace

TEST_CASE("force bounds, phi-schemes, touched under a tolerance: no more are wrong than known") {
  battery::at_most(known_touching, bounds().touching());
}
TEST_CASE("force bounds, phi-schemes, touched under a tolerance: none is wrong", "[!shouldfail][48]") {
  battery::none(bounds().touching());
}

TEST_CASE("force bounds, phi-schemes, inside under a tolerance: none is wrong") {
  battery::at_most(0, bounds().inside());
}
TEST_CASE("force bounds, phi-schemes, fixed steps: none is wrong") { battery::at_most(0, bounds().fixed_steps()); }

TEST_CASE("force bounds, phi-schemes, fixed steps, the end not asked: no more are wrong than known") {
  battery::at_most(known_blind, bounds().blind_steps());
}
TEST_CASE("force bounds, phi-schemes, fixed steps, the end not asked: none is wrong", "[!shouldfail][48]") {
  battery::none(bounds().blind_steps());
}
