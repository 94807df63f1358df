// method: every scheme, step by step. The quick half is method.test.cpp.
#include "study/stability/method_cases.hpp"

using namespace method_cases;

TEST_CASE("the matrix of a step is what the steppers do") {
  compare_with_stepper(forward_euler);
  compare_with_stepper(trapezoidal);
  compare_with_stepper(backward_euler);
  compare_with_stepper(midpoint);
  compare_with_stepper(phi(0.3));
  compare_with_stepper(phi_stage(0.7));
  compare_with_stepper(phi(0.2, 0.9));
  compare_with_stepper(symplectic_euler);
  compare_with_stepper(symplectic_euler_adjoint);
  compare_with_stepper(velocity_verlet);
  compare_with_stepper(tr_bdf2);
}
