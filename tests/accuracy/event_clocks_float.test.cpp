// Events on clocks of any t0 and Δt, in float. The members are those of event_clocks.hpp.
#include "accuracy/event_clocks.hpp"

using namespace event_clocks;

// Counts that may flip with a rounding have some room.
#if PHISTEP_STRESS
constexpr int members = 1400, known_tolerance = 10;
#elif PHISTEP_FULL
constexpr int members = 150, known_tolerance = 0;
#endif

namespace {

const Batteries<float>& clocks() {
  static const Batteries<float> all{"events, float",
                                    {
                                        subject<float>("velocity_verlet", velocity_verlet),
                                        subject<float>("trapezoidal", trapezoidal),
                                        subject<float>("tsit5", tsit5),
#if PHISTEP_STRESS
                                        fixed_subject<float>("forward_euler", forward_euler, false),
                                        fixed_subject<float>("symplectic_euler", symplectic_euler, false),
                                        subject<float>("rkn86", rkn86),
                                        subject<float>("rodas5p", rodas5p),
#endif
                                    },
                                    members};
  return all;
}

}  // namespace

TEST_CASE("event clocks, float: none is wrong") { battery::none(clocks().apart()); }

TEST_CASE("event clocks, float, near to each other: none is wrong") { battery::none(clocks().near()); }

TEST_CASE("event clocks, float, steps below 64 ulp: each is refused at the start") { battery::none(clocks().below()); }

// Some members have events some hundred ulp from each other in steps that are far longer.
TEST_CASE("event clocks, float, a tolerance: no more are wrong than known") {
  battery::at_most(known_tolerance, clocks().with_tolerance());
}
