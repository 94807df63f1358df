// The same problem in units of 2^±300: velocities are then up to 2^±600, and squares of them no numbers at all. Nothing
// may change: no bit, no counter. What is squared must have lost its unit before. Whole runs, Radau and springs:
// units.full.cpp.
#include "extremes/units_cases.hpp"

TEST_CASE("units of 2^300: products with the matrix") {
  check_all(
      [](const Units& u) {
        Scene scene{u};
        PhiStepper stepper{scene.y, chain(u), trapezoidal, mass(scene.masses), newton<MatrixFree<Eigen::BiCGSTAB>>()};
        return march(stepper, scene, 0.1, 10);
      },
      far);
}
