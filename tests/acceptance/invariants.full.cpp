// What a scheme keeps for ever, every scheme. The quick half: invariants.test.cpp.
#include "acceptance/invariants_cases.hpp"

TEST_CASE("Kepler: midpoint and Verlet keep the angular momentum to 1e-12 over 1e5 steps") {
  // A random walk of 1e5 roundings of 1e-16 is 3e-14.
  CHECK(angular_momentum_error(phistep::midpoint, 100000) <= 1e-12);
  CHECK(angular_momentum_error(phistep::velocity_verlet, 100000) <= 1e-12);
  CHECK(angular_momentum_error(phistep::symplectic_euler, 100000) <= 1e-12);
}

TEST_CASE("Kepler: the trapezoidal rule lets the angular momentum swing, but not drift") {
  // The midpoint rule in other coordinates: off by a bounded amount.
  const double first = angular_momentum_error(phistep::trapezoidal, 400 * 50);
  CHECK(first == Approx(7.6e-4).epsilon(0.05));
  CHECK(angular_momentum_error(phistep::trapezoidal, 400 * 250) == Approx(first).epsilon(0.05));
}

TEMPLATE_TEST_CASE_SIG("spring net: every phi keeps the linear momentum", "", ((bool damped), damped), false, true) {
  const auto force = [] {
    if constexpr (damped) return SpringNet::damped();
    else return SpringNet::elastic();
  }();
  for (const double phi : {0.25, 0.5, 0.7, 1.0}) {
    CAPTURE(phi);
    check_momentum(force, phistep::phi(phi), phi < 0.5 ? 0.01 : 0.1);
    check_momentum(force, phistep::phi_stage(phi), phi < 0.5 ? 0.01 : 0.1);
  }
  check_momentum(force, phistep::forward_euler, 0.002);
  check_momentum(force, phistep::phi(0.25, 0.75), 0.02);
  check_momentum(force, phistep::symplectic_euler, 0.02);
  check_momentum(force, phistep::velocity_verlet, 0.02);
}

TEST_CASE("midpoint, Verlet and symplectic Euler are symplectic, the trapezoidal rule is not") {
  CHECK(symplecticity_defect(phistep::midpoint) <= 1e-7);
  CHECK(symplecticity_defect(phistep::velocity_verlet) <= 1e-7);
  CHECK(symplecticity_defect(phistep::symplectic_euler) <= 1e-7);
  CHECK(symplecticity_defect(phistep::symplectic_euler_adjoint) <= 1e-7);
  CHECK(symplecticity_defect(phistep::trapezoidal) > 1e-4);
  CHECK(symplecticity_defect(phistep::phi(0.25, 0.75)) > 1e-4);  // area only where the force is linear
}
