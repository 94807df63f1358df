// What a scheme keeps for ever: momenta, symplecticity, a bounded energy error. Every scheme: the stress tier.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

#include "problems/forced.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "problems/show_digits.hpp"
#include "problems/spring_net.hpp"
#include "support/catch.hpp"
#if PHISTEP_FULL
#include "problems/argon.hpp"
#endif

using problems::HardeningSpring;
using problems::Kepler;
using problems::SpringNet;

namespace {

/// max |L − L₀| over n steps, 400 a period.
double angular_momentum_error(auto scheme, int n) {
  const Kepler kepler;
  Kepler::State y = kepler.start();
  phistep::PhiStepper stepper{y, kepler, scheme};
  const double h = Kepler::period / 400, start = Kepler::angular_momentum(y);
  double worst = 0;
  for (int k = 0; k < n; ++k) {
    problems::step(stepper, y, k * h, h);
    worst = std::max(worst, std::abs(Kepler::angular_momentum(y) - start));
  }
  return worst;
}

/// The momentum of a net over 200 steps.
[[maybe_unused]] void check_momentum_of(const std::function<void(SpringNet::State& y, double t, double h)>& step,
                                        double h) {
  SpringNet::State y = SpringNet::start();
  const Eigen::Vector2d before = SpringNet::momentum(y);
  const double scale = y.v.cwiseAbs().dot(SpringNet::masses());
  double worst = 0;
  for (int n = 0; n < 200; ++n) {
    step(y, n * h, h);
    worst = std::max(worst, (SpringNet::momentum(y) - before).norm() / scale);
  }
  CAPTURE(worst);
  CHECK(worst <= 1e-13);
}
void check_momentum(const auto& force, auto scheme, double h) {
  phistep::PhiStepper stepper{SpringNet::start(), force, scheme, phistep::mass(SpringNet::masses())};
  check_momentum_of([&](SpringNet::State& y, double t, double by) { problems::step(stepper, y, t, by); }, h);
}

/// |JᵀΩJ − Ω| of one step's Jacobian J, by central differences.
[[maybe_unused]] double symplecticity_defect_of(const std::function<void(HardeningSpring::State& y, double h)>& step) {
  using Matrix = Eigen::Matrix4d;
  constexpr double h = 0.3, delta = 1e-5;  // truncation δ² and rounding u/δ: 1e-10 and 1e-11
  const auto image = [&](int column, double by) {
    HardeningSpring::State z = HardeningSpring::start();
    (column < 2 ? z.r[column] : z.v[column - 2]) += by;
    step(z, h);
    return Eigen::Vector4d{z.r[0], z.r[1], z.v[0], z.v[1]};
  };
  Matrix J, omega = Matrix::Zero();
  for (int k = 0; k < 4; ++k) J.col(k) = (image(k, delta) - image(k, -delta)) / (2 * delta);
  omega.topRightCorner<2, 2>().setIdentity();
  omega.bottomLeftCorner<2, 2>() = -Eigen::Matrix2d::Identity();
  return (J.transpose() * omega * J - omega).cwiseAbs().maxCoeff();
}

double symplecticity_defect(auto scheme) {
  phistep::PhiStepper stepper{HardeningSpring::start(), HardeningSpring{}, scheme};
  return symplecticity_defect_of([&](HardeningSpring::State& y, double h) { problems::step(stepper, y, 0.0, h); });
}

}  // namespace

#if PHISTEP_FULL

using problems::Argon;

TEST_CASE("Kepler: midpoint and Verlet keep the angular momentum to 1e-12 over 1e5 steps") {
  // A random walk of 1e5 roundings of 1e-16 is 3e-14.
  CHECK(angular_momentum_error(phistep::midpoint, 100000) <= 1e-12);
  CHECK(angular_momentum_error(phistep::velocity_verlet, 100000) <= 1e-12);
}

TEMPLATE_TEST_CASE_SIG("spring net: every phi keeps the linear momentum", "", ((bool damped), damped), false) {
  check_momentum(SpringNet::elastic(), phistep::velocity_verlet, 0.02);
}

TEST_CASE("midpoint, Verlet and symplectic Euler are symplectic, the trapezoidal rule is not") {
  CHECK(symplecticity_defect(phistep::midpoint) <= 1e-7);
  CHECK(symplecticity_defect(phistep::velocity_verlet) <= 1e-7);
  CHECK(symplecticity_defect(phistep::trapezoidal) > 1e-4);
}

TEST_CASE("argon: Verlet's energy error is that of the textbook crystal, and falls as h^2") {
  // max |H − H₀|/k_B over 0.02 ns. Longer runs are chaotic: a shift of 1e-15 moves them.
  const auto energy_error = [](int steps) {
    constexpr double end = 0.02;  // [ns]
    Argon::State y = Argon::start();
    phistep::PhiStepper stepper{y, Argon{}, phistep::velocity_verlet, phistep::mass(Argon::mass)};
    const double start = Argon::energy(y), h = end / steps;
    double worst = 0;
    for (int n = 0; n < steps; ++n) {
      problems::step(stepper, y, n * h, h);
      worst = std::max(worst, std::abs(Argon::energy(y) - start));
    }
    return worst;
  };
  CHECK(Argon::energy(Argon::start()) == Approx(-1260.2066229194).epsilon(1e-12));
  const double at_40_fs = energy_error(500), at_20_fs = energy_error(1000);
  // The digits given are what is known: half a unit of the last one.
  CHECK(std::abs(at_40_fs - 1.5898) <= 0.5e-4);
  CHECK(std::abs(at_20_fs - 0.4206) <= 0.5e-4);
  CHECK(std::abs(at_40_fs / at_20_fs - 3.780) <= 0.5e-3);
}

#elif PHISTEP_STRESS
// What a scheme keeps for ever, every scheme.

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

#endif
