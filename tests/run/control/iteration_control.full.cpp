// iteration_control, every scheme. The quick half is iteration_control.test.cpp.
#include "run/control/iteration_control_cases.hpp"

using namespace iteration_cases;

TEST_CASE("an oscillator settles at K_d ± 1 iterations, at every φ, from far too short and from far too long") {
  // Its contraction is φ²ω²Δt² exactly.
  for (const double first : {1e-6, 1e-2, 0.3, 50.0})
    for (const int desired : {5, 6, 8})
      for (const double tol : {0.0, 1e-6}) {
        CAPTURE(first, desired, tol);
        CHECK(off_desired(Pull{400}, trapezoidal, first, desired, tol) <= 1);
        CHECK(off_desired(Pull{400}, backward_euler, first, desired, tol) <= 1);
      }
}

TEST_CASE("smaller_of: neither the error nor the iterations are more than allowed") {
  check_smaller_of(
      Swing{One(1), One(0)}, [](double omega_squared) { return Pull{omega_squared}; }, trapezoidal);
  Swing y{One(1), One(0)};
  PhiStepper stepper{y, Pull{1}, trapezoidal};
  CHECK(integrate(stepper, y, {0, 5}, smaller_of(tolerance{.rtol = 1e-5}, {.max_steps = 3})).outcome ==
        Outcome::too_many_steps);
}

TEST_CASE("an explicit scheme has no iterations: the step grows to its bound") {
  check_growth(Swing{One(1), One(0)}, Pull{1});
}

TEST_CASE("a start at which the iteration diverges recovers, and the run says what held it") {
  check_recovery(Swing{One(1), One(0)}, Pull{1e4}, trapezoidal);
}
