#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <cmath>

#include "problems/kepler_force.hpp"

namespace problems {

/// Two bodies, G(m₁+m₂) = 1, semi-major axis 1 and hence period 2π, starting at the pericentre.
struct Kepler : KeplerForce {
  using State = phistep::Motion<Vector>;
  static constexpr double period = 6.2831853071795864769;
  double eccentricity;

  explicit Kepler(double e = 0.6) : eccentricity{e} {}

  [[nodiscard]] State start() const {
    return {Vector{1 - eccentricity, 0}, Vector{0, std::sqrt((1 + eccentricity) / (1 - eccentricity))}};
  }
  [[nodiscard]] static double angular_momentum(const State& y) { return y.r[0] * y.v[1] - y.r[1] * y.v[0]; }

  /// By Kepler's equation E − e sin E = t.
  [[nodiscard]] State exact(double t) const {
    const double e = eccentricity, b = std::sqrt(1 - e * e);
    double E = t;
    for (int k = 0; k < 50; ++k) E -= (E - e * std::sin(E) - t) / (1 - e * std::cos(E));
    const double rate = 1 / (1 - e * std::cos(E));
    return {Vector{std::cos(E) - e, b * std::sin(E)}, Vector{-std::sin(E) * rate, b * std::cos(E) * rate}};
  }
};

}  // namespace problems
