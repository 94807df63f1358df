// Events on clocks of any t0 and Δt, in double, by implicit schemes. The members are those of event_clocks.hpp.
#include "accuracy/event_clocks.hpp"

using namespace event_clocks;

// Counts that may flip with a rounding have some room.
#if PHISTEP_STRESS
constexpr int members = 1200, known_tolerance = 14;
#elif PHISTEP_FULL
constexpr int members = 150, known_tolerance = 0;
#endif

namespace {

const Batteries<double>& clocks() {
  static const Batteries<double> all{"events, double, implicit",
                                     {
                                         subject<double>("trapezoidal", trapezoidal),
                                         subject<double>("tr_bdf2", tr_bdf2),
                                         subject<double>("generalized_alpha(0.5)", generalized_alpha(0.5)),
                                         subject<double>("radau", radau),
#if PHISTEP_STRESS
                                         subject<double>("backward_euler", backward_euler, false),
                                         subject<double>("midpoint", midpoint),
                                         subject<double>("rodas5p", rodas5p),
#endif
                                     },
                                     members};
  return all;
}

}  // namespace

TEST_CASE("event clocks, double, implicit: none is wrong") { battery::none(clocks().apart()); }

TEST_CASE("event clocks, double, implicit, near to each other: none is wrong") { battery::none(clocks().near()); }

TEST_CASE("event clocks, double, implicit, steps below 64 ulp: each is refused at the start") {
  battery::none(clocks().below());
}

// Some members have events some hundred ulp from each other in steps that are far longer.
TEST_CASE("event clocks, double, implicit, a tolerance: no more are wrong than known") {
  battery::at_most(known_tolerance, clocks().with_tolerance());
}
