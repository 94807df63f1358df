// A state inside of a step is as accurate as those at its ends: first-order schemes of order 1 and 2. The quick half:
// tolerance_samples.test.cpp.

#include "acceptance/tolerance_samples_cases.hpp"

using namespace samples;

TEST_CASE("samples are as accurate as steps") {
  check_flow("forward Euler", forward_euler, smooth, 3, 5);
  check_flow("phi = 0.7", phi(0.7), smooth, 3, 5);
  check_flow("phi = 0.7", phi(0.7), stiff, 3, 4);
  check_flow("backward Euler", backward_euler, smooth, 3, 5);
  check_flow("backward Euler", backward_euler, stiff, 3, 4);
  check_flow("trapezoidal", trapezoidal, smooth, 3, 8);
  check_flow("trapezoidal", trapezoidal, stiff, 3, 7);
  check_flow("midpoint", midpoint, smooth, 3, 8);
  check_flow("midpoint", midpoint, stiff, 3, 6);
  check_flow("TR-BDF2", tr_bdf2, smooth, 3, 8);
  check_flow("TR-BDF2", tr_bdf2, stiff, 3, 7);
  check_flow("Rannacher", rannacher, smooth, 3, 8);
  check_flow("Rannacher", rannacher, stiff, 3, 7);
}
