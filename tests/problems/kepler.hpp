#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <cmath>

namespace problems {

/// Two bodies, G(m₁+m₂) = 1, semi-major axis 1 and hence period 2π, starting at the pericentre.
struct Kepler {
  using Vector = Eigen::Vector2d;
  using State = phistep::Motion<Vector>;
  static constexpr double period = 6.2831853071795864769;
  double eccentricity = 0.6;

  [[nodiscard]] State start() const {
    return {Vector{1 - eccentricity, 0}, Vector{0, std::sqrt((1 + eccentricity) / (1 - eccentricity))}};
  }
  Vector operator()(const Vector& r) const { return -r / std::pow(r.squaredNorm(), 1.5); }
  [[nodiscard]] Eigen::Matrix2d jacobian(const Vector& r) const {
    const double d = r.norm();
    return (3 * r * r.transpose() / (d * d) - Eigen::Matrix2d::Identity()) / (d * d * d);
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
