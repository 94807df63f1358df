// The same problem in units of 2^±300, by the dearer schemes. The quick half: units.test.cpp.
#include "extremes/units_cases.hpp"

TEST_CASE("units of 2^300: radau") { check_motion(radau, chain, to_rounding, 0.1, 10); }
TEST_CASE("units of 2^300: products with the matrix") {
  check_motion(
      trapezoidal, chain, [](const Units&) { return newton<MatrixFree<Eigen::BiCGSTAB>>(); }, 0.1, 10);
}
TEST_CASE("units of 2^300: networks of springs") {
  check_all(
      [&](const Units& u) {
        Net net{u};
        PhiStepper stepper{net.y, spring_network<3>(net.springs) + net.gravity(), backward_euler, mass(net.masses)};
        return march(stepper, net, 0.02, 10);
      },
      far);
}
