// The order of every scheme, seen from both sides, on problems where nothing helps it: nonlinear, non-autonomous,
// velocity-dependent. The named schemes: order.full.cpp.

#include "convergence/order_cases.hpp"

TEST_CASE("first order: an endpoint step with phi != 1/2 is of order 1") {
  for (const double phi : {0.0, 0.25, 0.75, 1.0}) {
    CAPTURE(phi);
    check_flow(phistep::phi(phi), 1, fine);
  }
}

TEST_CASE("first order: a stage step with phi != 1/2 is of order 1") {
  for (const double phi : {0.0, 0.25, 0.75, 1.0}) {
    CAPTURE(phi);
    check_flow(phistep::phi_stage(phi), 1, fine);
  }
}

TEST_CASE("first order: phi = 1/2 is of order 2 in both forms") {
  check_flow(phistep::phi(0.5), 2, coarse);
  check_flow(phistep::phi_stage(0.5), 2, coarse);
}

TEST_CASE("motion: an endpoint step with phi != 1/2 is of order 1") {
  for (const double phi : {0.0, 0.25, 0.75, 1.0}) {
    CAPTURE(phi);
    check_motion(phistep::phi(phi), 1, fine);
  }
}

TEST_CASE("motion: a stage step with phi != 1/2 is of order 1") {
  for (const double phi : {0.0, 0.25, 0.75, 1.0}) {
    CAPTURE(phi);
    check_motion(phistep::phi_stage(phi), 1, fine);
  }
}

TEST_CASE("motion: phi = 1/2 is of order 2 in both forms") { check_motion(phistep::phi(0.5, 0.5), 2, coarse); }

TEST_CASE("motion: a pair is of order 2 at (1/2, 1/2) only") {
  check_motion(phistep::phi(0.25, 0.75), 1, fine);
  check_motion(phistep::phi(0.5, 0.25), 1, fine);
  check_motion(phistep::phi(1, 0.5), 1, fine);
}

TEST_CASE("velocity Verlet is of order 2, with and without a force that uses v") {
  check_motion(phistep::velocity_verlet, 2, coarse);
  check_order(errors(100, [](int n) { return kepler_error(phistep::velocity_verlet, n); }), 2);
}
