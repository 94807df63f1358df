// The undamped oscillator r'' = −ω²r: what a φ-step does to its energy, for a = ωΔt from 1e-3 to 1e6.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "problems/march.hpp"
#include "problems/oscillator.hpp"
#include "problems/show_digits.hpp"
#include "support/catch.hpp"

using problems::Oscillator;

namespace {

constexpr double u = std::numeric_limits<double>::epsilon() / 2;  // unit round-off

/// |E⁺ − ratio·E| relative to E, the worst of many starting phases.
double energy_defect(const Oscillator& oscillator, auto scheme, double phi) {
  const double omega = std::sqrt(oscillator.omega_squared);
  const long double ratio = Oscillator::energy_ratio(oscillator.omega_squared, phi);
  Oscillator::State y{Oscillator::Vector{1}, Oscillator::Vector{0}};
  phistep::PhiStepper stepper{y, oscillator, scheme};
  long double worst = 0;
  for (int k = 0; k < 64; ++k) {
    y.r[0] = std::cos(0.1 * k);
    y.v[0] = omega * std::sin(0.1 * k);
    const long double before = oscillator.energy(y);
    problems::step(stepper, y, 0.0, 1.0);
    worst = std::max(worst, std::abs(oscillator.energy(y) / before - ratio));
  }
  return static_cast<double>(worst);
}

}  // namespace

TEST_CASE("oscillator: a phi-step multiplies the energy by (1 + (1-phi)^2 a^2)/(1 + phi^2 a^2)") {
  for (const double phi : {0.0, 0.1, 0.25, 0.5, 0.6, 0.7, 0.9, 1.0})
    for (int exponent = -6; exponent <= 12; ++exponent) {
      const double a = std::pow(10.0, exponent / 2.0);
      const Oscillator oscillator{a * a};
      // A few roundings of each term of ½v² + ½ω²r², after the step or before it.
      const double bound =
          50 * u * std::max(1.0, static_cast<double>(Oscillator::energy_ratio(oscillator.omega_squared, phi)));
      const double endpoint = energy_defect(oscillator, phistep::phi(phi), phi);
      const double stage = energy_defect(oscillator, phistep::phi_stage(phi), phi);
      CAPTURE(phi, a, bound, endpoint, stage);
      CHECK(endpoint <= bound);
      CHECK(stage <= bound);
    }
}

TEST_CASE("oscillator: forward Euler gains energy by 1 + a^2 a step, backward Euler loses as much") {
  // Named schemes, a = 1/2: 1.25 and its inverse.
  CHECK(energy_defect({0.25}, phistep::forward_euler, 0) <= 50 * u * 1.25);
  CHECK(energy_defect({0.25}, phistep::backward_euler, 1) <= 50 * u);
  CHECK(static_cast<double>(Oscillator::energy_ratio(0.25L, 0)) == 1.25);
  CHECK(static_cast<double>(Oscillator::energy_ratio(0.25L, 1)) == 0.8);
}

TEST_CASE("oscillator: phi = 1/2 keeps the energy to 1e-12 over a million steps") {
  const auto check = [](double a, auto scheme, double limit) {
    const Oscillator oscillator{a * a};
    Oscillator::State y{Oscillator::Vector{1}, Oscillator::Vector{0.3 * a}};
    phistep::PhiStepper stepper{y, oscillator, scheme};
    const long double start = oscillator.energy(y);
    long double worst = 0;
    for (int n = 0; n < 1000000; ++n) {
      problems::step(stepper, y, static_cast<double>(n), 1.0);
      if (n % 100 == 99) worst = std::max(worst, std::abs(oscillator.energy(y) / start - 1));
    }
    CAPTURE(a, oscillator.omega_squared);
    CHECK(static_cast<double>(worst) <= limit);
  };
  // A random walk of a million roundings is 1e3 u = 1e-13.
  for (const double a : {1e-3, 0.1, 1e3, 1e6}) {
    check(a, phistep::trapezoidal, 1e-12);
    check(a, phistep::midpoint, 1e-12);
  }
  // Known shortfall: around a = 1 the second Newton correction is nothing but rounding, yet correlated with the
  // iterate's own, and the energy drifts by up to 7e-18 a step (measured: 5.7e-12 after a million). One solve a step
  // for affine forces would end it; until then this bound keeps it from growing.
  for (const double a : {0.7, 1.0, 3.0}) {
    check(a, phistep::trapezoidal, 1e-11);
    check(a, phistep::midpoint, 1e-11);
  }
}

TEST_CASE("oscillator: a pair is area-preserving where its two phi add up to 1") {
  // det = (1 + (1−φ_f)(1−φ_d) a²)/(1 + φ_f φ_d a²), from the images of (1, 0) and (0, 1).
  const auto determinant = [](double a, double phi_force, double phi_drift) {
    const Oscillator oscillator{a * a};
    Oscillator::State x{Oscillator::Vector{1}, Oscillator::Vector{0}};
    Oscillator::State y{Oscillator::Vector{0}, Oscillator::Vector{1}};
    phistep::PhiStepper stepper{x, oscillator, phistep::phi(phi_force, phi_drift)};
    problems::step(stepper, x, 0.0, 1.0);
    problems::step(stepper, y, 0.0, 1.0);
    return x.r[0] * y.v[0] - x.v[0] * y.r[0];
  };
  for (const double a : {0.1, 0.8, 1.7})
    for (const double phi_force : {0.0, 0.25, 0.5, 1.0})
      for (const double phi_drift : {0.0, 0.25, 0.75, 1.0}) {
        const double expected = (1 + (1 - phi_force) * (1 - phi_drift) * a * a) / (1 + phi_force * phi_drift * a * a);
        CAPTURE(a, phi_force, phi_drift);
        CHECK(determinant(a, phi_force, phi_drift) == Approx(expected).epsilon(1e-14).margin(1e-14));
        if (phi_force + phi_drift == 1) CHECK(expected == Approx(1).epsilon(1e-14));
      }
}
