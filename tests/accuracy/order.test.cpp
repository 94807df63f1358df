// The order of every scheme, seen from both sides, on problems where nothing helps it: nonlinear, non-autonomous,
// velocity-dependent. The named schemes: the full tier.
#include <phistep/phistep.hpp>

#include <cmath>

#include "accuracy/observed_order.hpp"
#include "problems/dahlquist.hpp"
#include "problems/forced.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "problems/show_digits.hpp"
#include "support/catch.hpp"

using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::march;

namespace {

constexpr double end = 2;

double flow_error(auto scheme, int n) {
  using Problem = problems::ForcedFlow<>;
  const auto y = Problem::exact(0);
  phistep::PhiStepper stepper{y, Problem{}, scheme, phistep::capacity(Problem::capacity)};
  return distance(march(stepper, y, 0.0, end, n), Problem::exact(end));
}

double motion_error(auto scheme, int n) {
  using Problem = problems::ForcedMotion<>;
  const auto y = Problem::exact(0);
  phistep::PhiStepper stepper{y, Problem{}, scheme, phistep::mass(Problem::mass)};
  return distance(march(stepper, y, 0.0, end, n), Problem::exact(end));
}

double kepler_error(auto scheme, int n) {
  const problems::Kepler kepler{0.3};
  phistep::PhiStepper stepper{kepler.start(), kepler, scheme};
  return distance(march(stepper, kepler.start(), 0.0, end, n), kepler.exact(end));
}

void check_flow(auto scheme, double order, int n) {
  check_order(errors(n, [&](int steps) { return flow_error(scheme, steps); }), order);
}
void check_motion(auto scheme, double order, int n) {
  check_order(errors(n, [&](int steps) { return motion_error(scheme, steps); }), order);
}

// The next term of the error is O(h) beside the leading one for order 1, O(h²) for order 2: at these n it moves the
// observed order by less than 0.05.
constexpr int fine = 400, coarse = 50;

}  // namespace

#if PHISTEP_QUICK

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

#elif PHISTEP_FULL
// The order of every scheme, seen from both sides: the named ones.

TEST_CASE("first order: an endpoint step with phi != 1/2 is of order 1") {
  for (const double phi : {0.0, 0.25, 0.75, 1.0}) {
    CAPTURE(phi);
    check_flow(phistep::phi(phi), 1, fine);
  }
  check_flow(phistep::forward_euler, 1, fine);
  check_flow(phistep::backward_euler, 1, fine);
}

TEST_CASE("first order: phi = 1/2 is of order 2 in both forms") {
  check_flow(phistep::trapezoidal, 2, coarse);
  check_flow(phistep::phi(0.5), 2, coarse);
  check_flow(phistep::midpoint, 2, coarse);
  check_flow(phistep::phi_stage(0.5), 2, coarse);
  check_flow(phistep::from_spectral_radius(1), 2, coarse);
}

TEST_CASE("motion: an endpoint step with phi != 1/2 is of order 1") {
  for (const double phi : {0.0, 0.25, 0.75, 1.0}) {
    CAPTURE(phi);
    check_motion(phistep::phi(phi), 1, fine);
  }
  check_motion(phistep::forward_euler, 1, fine);
  check_motion(phistep::backward_euler, 1, fine);
}

TEST_CASE("motion: phi = 1/2 is of order 2 in both forms") {
  check_motion(phistep::trapezoidal, 2, coarse);
  check_motion(phistep::midpoint, 2, coarse);
  check_motion(phistep::phi(0.5, 0.5), 2, coarse);
}

TEST_CASE("motion: a pair is of order 2 at (1/2, 1/2) only") {
  check_motion(phistep::phi(0.25, 0.75), 1, fine);
  check_motion(phistep::phi(0.5, 0.25), 1, fine);
  check_motion(phistep::phi(1, 0.5), 1, fine);
  check_motion(phistep::symplectic_euler, 1, fine);
  check_motion(phistep::symplectic_euler_adjoint, 1, fine);
}

TEST_CASE("symplectic Euler and its adjoint are of order 1 where the force ignores v") {
  check_order(errors(fine, [](int n) { return kepler_error(phistep::symplectic_euler, n); }), 1);
  check_order(errors(fine, [](int n) { return kepler_error(phistep::symplectic_euler_adjoint, n); }), 1);
}

TEST_CASE("the schemes know their order") {
  const problems::Kepler kepler;
  const auto order = [&kepler](auto scheme) { return phistep::PhiStepper{kepler.start(), kepler, scheme}.order(); };
  CHECK(order(phistep::forward_euler) == 1);
  CHECK(order(phistep::backward_euler) == 1);
  CHECK(order(phistep::phi(0.25)) == 1);
  CHECK(order(phistep::phi(0.5)) == 2);
  CHECK(order(phistep::trapezoidal) == 2);
  CHECK(order(phistep::midpoint) == 2);
  CHECK(order(phistep::phi(0.5, 0.5)) == 2);
  CHECK(order(phistep::phi(0.5, 0.25)) == 1);
  CHECK(order(phistep::symplectic_euler) == 1);
  CHECK(order(phistep::velocity_verlet) == 2);
  CHECK(order(phistep::tr_bdf2) == 2);
  CHECK(order(phistep::rannacher) == 2);
}

TEST_CASE("error constants: e^z - R(z) is (1/2 - phi) z^2, and -z^3/12 at phi = 1/2") {
  // e^z − R = (½−φ)z² + (1/6−φ²)z³ + …: the next term is below 1 % for these z and φ.
  const auto local_error = [](double z, auto scheme) {
    const problems::Dahlquist problem{z};
    problems::Dahlquist::State y{1};
    phistep::PhiStepper stepper{y, problem, scheme};
    problems::step(stepper, y, 0.0, 1.0);
    return std::expm1(z) - (y[0] - 1);
  };
  const double z = -2e-3;
  for (const double phi : {0.0, 0.25, 0.75, 1.0}) {
    CAPTURE(phi);
    CHECK(local_error(z, phistep::phi(phi)) / (z * z) == Approx(0.5 - phi).epsilon(0.02));
    CHECK(local_error(z, phistep::phi_stage(phi)) / (z * z) == Approx(0.5 - phi).epsilon(0.02));
  }
  CHECK(local_error(z, phistep::trapezoidal) / (z * z * z) == Approx(-1.0 / 12).epsilon(0.02));
  CHECK(local_error(z, phistep::midpoint) / (z * z * z) == Approx(-1.0 / 12).epsilon(0.02));
}

TEST_CASE("error constants: on a nonlinear problem the error is proportional to 1/2 - phi") {
  // To first order in h the error is (½−φ) h E(t) with the same E for every φ in both forms. The next term, O(h), is
  // cancelled from the errors by extrapolation: 2·e(h/2)·2 − e(h) has none.
  const auto leading = [](auto scheme) {
    using Problem = problems::ForcedMotion<>;
    const auto y = Problem::exact(0), exact = Problem::exact(end);
    phistep::PhiStepper stepper{y, Problem{}, scheme, phistep::mass(Problem::mass)};
    const auto error = [&](int n) { return (march(stepper, y, 0.0, end, n).v - exact.v).eval(); };
    return (4 * error(2 * fine) - error(fine)).eval();
  };
  const Eigen::Vector2d at_zero = leading(phistep::forward_euler);
  for (const double phi : {0.25, 0.75, 1.0}) {
    CAPTURE(phi);
    const double expected = (0.5 - phi) / 0.5;
    CHECK(distance(leading(phistep::phi(phi)), expected * at_zero) <= 0.02 * std::abs(expected) * at_zero.norm());
    CHECK(distance(leading(phistep::phi_stage(phi)), expected * at_zero) <= 0.02 * std::abs(expected) * at_zero.norm());
  }
}

#endif
