// Events on clocks of any t0 and Δt, in double, by explicit schemes. The members are those of event_clocks.hpp.
#include "accuracy/event_clocks.hpp"

using namespace event_clocks;

// Counts that may flip with a rounding have some room.
#if PHISTEP_STRESS
constexpr int members = 1400, known_tolerance = 10;
#elif PHISTEP_FULL
constexpr int members = 200, known_tolerance = 0;
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

TEST_CASE("event clocks, double: none is wrong") { battery::none(clocks().apart()); }

TEST_CASE("event clocks, double, near to each other: none is wrong") { battery::none(clocks().near()); }

TEST_CASE("event clocks, double, steps below 64 ulp: each is refused at the start") { battery::none(clocks().below()); }

// Some members have events some hundred ulp from each other in steps that are far longer.
TEST_CASE("event clocks, double, a tolerance: no more are wrong than known") {
  battery::at_most(known_tolerance, clocks().with_tolerance());
}
