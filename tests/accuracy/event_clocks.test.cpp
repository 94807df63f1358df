// Events on clocks of any t0 and Δt, in double, by explicit schemes. The members are those of event_clocks.hpp.
#include "accuracy/event_clocks.hpp"

using namespace event_clocks;

// Counts that may flip with a rounding have some room.
#if PHISTEP_STRESS
constexpr int members = 1400, known_apart = 255, known_near = 350, known_below = 350, known_tolerance = 178;
#elif PHISTEP_FULL
constexpr int members = 200, known_apart = 42, known_near = 50, known_below = 50, known_tolerance = 22;
#endif

namespace {

const Batteries<double>& clocks() {
  static const Batteries<double> all{"events, double",
                                     {
                                         subject<double>("forward_euler", forward_euler, false),
                                         subject<double>("velocity_verlet", velocity_verlet),
                                         subject<double>("tsit5", tsit5),
                                         subject<double>("rkn86", rkn86),
#if PHISTEP_STRESS
                                         subject<double>("dop853", dop853),
                                         fixed_subject<double>("symplectic_euler", symplectic_euler, false),
                                         fixed_subject<double>("srkn6b", srkn6b),
#endif
                                     },
                                     members};
  return all;
}

}  // namespace

// Today an event may happen 1024 ulp of the time too early, where a step ends that near to it.
TEST_CASE("event clocks, double: no more are wrong than known") { battery::at_most(known_apart, clocks().apart()); }
TEST_CASE("event clocks, double: none is wrong", "[!shouldfail][47-A]") { battery::none(clocks().apart()); }

TEST_CASE("event clocks, double, near to each other: no more are wrong than known") {
  battery::at_most(known_near, clocks().near());
}
TEST_CASE("event clocks, double, near to each other: none is wrong", "[!shouldfail][47-A]") {
  battery::none(clocks().near());
}

TEST_CASE("event clocks, double, steps below 64 ulp: no more are accepted than known") {
  battery::at_most(known_below, clocks().below());
}
TEST_CASE("event clocks, double, steps below 64 ulp: each is refused at the start", "[!shouldfail][47-A]") {
  battery::none(clocks().below());
}

TEST_CASE("event clocks, double, a tolerance: no more are wrong than known") {
  battery::at_most(known_tolerance, clocks().with_tolerance());
}
TEST_CASE("event clocks, double, a tolerance: none is wrong", "[!shouldfail][47-A]") {
  battery::none(clocks().with_tolerance());
}
