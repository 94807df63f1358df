// A state inside of a step is as accurate as those at its ends: motions. In short: tolerance_samples.test.cpp.

#include "accuracy/tolerance_samples_cases.hpp"

using namespace samples;

TEST_CASE("samples are as accurate as steps") {
  check_motion("forward Euler", forward_euler, 3, 5);
  check_motion("symplectic Euler", symplectic_euler, 3, 5);
  check_motion("its adjoint", symplectic_euler_adjoint, 3, 5);
  check_motion("velocity Verlet", velocity_verlet, 3, 8);
  check_motion("trapezoidal", trapezoidal, 3, 8);
  check_motion("midpoint", midpoint, 3, 8);
  check_motion("TR-BDF2", tr_bdf2, 3, 8);
  check_motion("rkn86", rkn86, 3, 10);
  check_motion("rkn1210", rkn1210, 3, 12);
  check_motion("rkn1210, compensated", compensated(rkn1210), 3, 12);
  check_motion("srkn6b", srkn6b, 3, 10);
  check_motion("srkn11b", srkn11b, 3, 10);
  check_motion("composed", composed(velocity_verlet), 3, 10);
}
