// Events on clocks of any t0 and Δt, in double, by implicit schemes. The members are those of event_clocks.hpp.
#include "accuracy/event_clocks.hpp"

using namespace event_clocks;

// Counts that may flip with a rounding have some room.
#if PHISTEP_STRESS
constexpr int members = 1200, known_apart = 248, known_near = 300, known_below = 300, known_tolerance = 120;
#elif PHISTEP_FULL
constexpr int members = 150, known_apart = 35, known_near = 37, known_below = 37, known_tolerance = 13;
#endif

namespace {

const Batteries<double>& clocks() {
  static const Batteries<double> all{"events, double, implicit",
                                     {
                                         subject<double>("trapezoidal", trapezoidal),
                                         subject<double>("tr_bdf2", tr_bdf2),
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

// Today an event may happen 1024 ulp of the time too early, where a step ends that near to it.
TEST_CASE("event clocks, double, implicit: no more are wrong than known") {
  battery::at_most(known_apart, clocks().apart());
}
TEST_CASE("event clocks, double, implicit: none is wrong", "[!shouldfail][47-A]") { battery::none(clocks().apart()); }

TEST_CASE("event clocks, double, implicit, near to each other: no more are wrong than known") {
  battery::at_most(known_near, clocks().near());
}
TEST_CASE("event clocks, double, implicit, near to each other: none is wrong", "[!shouldfail][47-A]") {
  battery::none(clocks().near());
}

TEST_CASE("event clocks, double, implicit, steps below 64 ulp: no more are accepted than known") {
  battery::at_most(known_below, clocks().below());
}
TEST_CASE("event clocks, double, implicit, steps below 64 ulp: each is refused at the start", "[!shouldfail][47-A]") {
  battery::none(clocks().below());
}

TEST_CASE("event clocks, double, implicit, a tolerance: no more are wrong than known") {
  battery::at_most(known_tolerance, clocks().with_tolerance());
}
TEST_CASE("event clocks, double, implicit, a tolerance: none is wrong", "[!shouldfail][47-A]") {
  battery::none(clocks().with_tolerance());
}
