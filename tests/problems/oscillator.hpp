#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

namespace problems {

/// r'' = −ω² r, of unit mass. In units of Δt: a = ωΔt.
struct Oscillator {
  using Vector = Eigen::Matrix<double, 1, 1>;
  using State = phistep::Motion<Vector>;
  double omega_squared;  ///< [1/time²]

  Vector operator()(const Vector& r) const { return -omega_squared * r; }
  Vector jacobian(const Vector& /*r*/) const { return Vector{-omega_squared}; }

  /// In extended precision: the error to be measured is near that of the sum itself.
  [[nodiscard]] long double energy(const State& y) const {
    const long double r = y.r[0], v = y.v[0];
    return (v * v + static_cast<long double>(omega_squared) * r * r) / 2;
  }
  /// Energy after a φ-step over energy before, exactly, with a² = (ωΔt)².
  [[nodiscard]] static long double energy_ratio(long double a_squared, double phi) {
    const long double p = phi, q = 1 - p;
    return (1 + q * q * a_squared) / (1 + p * p * a_squared);
  }
};

}  // namespace problems
