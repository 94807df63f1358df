// Events on clocks of any t0 and Δt, in float. The members are those of event_clocks.hpp.
#include "accuracy/event_clocks.hpp"

using namespace event_clocks;

// Counts that may flip with a rounding have some room.
#if PHISTEP_STRESS
constexpr int members = 1400, known_apart = 650, known_near = 350, known_below = 350, known_tolerance = 290;
#elif PHISTEP_FULL
constexpr int members = 150, known_apart = 75, known_near = 37, known_below = 37, known_tolerance = 20;
#endif

namespace {

const Batteries<float>& clocks() {
  static const Batteries<float> all{"events, float",
                                    {
                                        subject<float>("velocity_verlet", velocity_verlet),
                                        subject<float>("trapezoidal", trapezoidal),
                                        subject<float>("tsit5", tsit5),
#if PHISTEP_STRESS
                                        subject<float>("forward_euler", forward_euler, false),
                                        fixed_subject<float>("symplectic_euler", symplectic_euler, false),
                                        subject<float>("rkn86", rkn86),
                                        subject<float>("rodas5p", rodas5p),
#endif
                                    },
                                    members};
  return all;
}

}  // namespace

// Today an event may happen 1024 ulp of the time too early, where a step ends that near to it.
TEST_CASE("event clocks, float: no more are wrong than known") { battery::at_most(known_apart, clocks().apart()); }
TEST_CASE("event clocks, float: none is wrong", "[!shouldfail][47-A]") { battery::none(clocks().apart()); }

TEST_CASE("event clocks, float, near to each other: no more are wrong than known") {
  battery::at_most(known_near, clocks().near());
}
TEST_CASE("event clocks, float, near to each other: none is wrong", "[!shouldfail][47-A]") {
  battery::none(clocks().near());
}

TEST_CASE("event clocks, float, steps below 64 ulp: no more are accepted than known") {
  battery::at_most(known_below, clocks().below());
}
TEST_CASE("event clocks, float, steps below 64 ulp: each is refused at the start", "[!shouldfail][47-A]") {
  battery::none(clocks().below());
}

TEST_CASE("event clocks, float, a tolerance: no more are wrong than known") {
  battery::at_most(known_tolerance, clocks().with_tolerance());
}
TEST_CASE("event clocks, float, a tolerance: none is wrong", "[!shouldfail][47-A]") {
  battery::none(clocks().with_tolerance());
}
