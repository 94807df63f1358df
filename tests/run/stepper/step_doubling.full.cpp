// Step doubling by every scheme; the quick half is step_doubling.test.cpp.
#include "run/stepper/step_doubling_cases.hpp"

using namespace step_doubling_cases;

TEST_CASE("the result is that of two half steps, to the bit; the error is a third of the difference at order 2") {
  check_halves(midpoint, 3), check_halves(phi_stage(0.7), 1), check_halves(rannacher, 3);
}

TEST_CASE("after a rejection everything is as it was, to the bit, and the next steps are those of one never tried") {
  check_rejections(Flow::exact(0.1), Flow{}, midpoint, capacity(Flow::capacity));
  check_rejections(Flow::exact(0.1), Flow{}, trapezoidal, capacity(Flow::capacity));
  check_rejections(Flow::exact(0.1), Flow{}, rannacher(2), capacity(Flow::capacity));
  check_rejections(Swing::exact(0.1), Swing{}, velocity_verlet, mass(Swing::mass));
  check_rejections(Swing::exact(0.1), Swing{}, symplectic_euler, mass(Swing::mass));
}

TEST_CASE("a force with memory: failure and exception at every call leave state, history and trace as they were") {
  check_failures(midpoint), check_failures(trapezoidal), check_failures(forward_euler), check_failures(rannacher);
}
