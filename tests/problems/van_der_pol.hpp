#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

namespace problems {

/// r'' = μ (1 − r²) r' − r with μ = 5, from (2, 0) to t = 8: along a slow branch and over one fast jump.
struct VanDerPol {
  using Vector = Eigen::Matrix<double, 1, 1>;
  using State = phistep::Motion<Vector>;
  static constexpr double mu = 5, end = 8;

  [[nodiscard]] static State start() { return {Vector{2}, Vector{0}}; }
  Vector operator()(const Vector& r, const Vector& v) const { return Vector{mu * (1 - r[0] * r[0]) * v[0] - r[0]}; }
  [[nodiscard]] phistep::MotionJacobian<Vector, Vector> jacobian(const Vector& r, const Vector& v) const {
    return {Vector{-2 * mu * r[0] * v[0] - 1}, Vector{mu * (1 - r[0] * r[0])}};
  }

  /// At t = 8, by a Taylor series of 30 digits and more.
  [[nodiscard]] static State exact() { return {Vector{-1.6747611177007554722}, Vector{0.18135485598783776917}}; }
};

}  // namespace problems
