#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <cmath>

namespace problems {

/// θ'' = −sin θ − θ'/4 from (2, 0) to t = 10: far from linear at first, and a force that needs the velocity.
struct DampedPendulum {
  using Vector = Eigen::Matrix<double, 1, 1>;
  using State = phistep::Motion<Vector>;
  static constexpr double damping = 0.25, end = 10;

  [[nodiscard]] static State start() { return {Vector{2}, Vector{0}}; }
  Vector operator()(const Vector& r, const Vector& v) const { return Vector{-std::sin(r[0]) - damping * v[0]}; }

  /// At t = 10, by a Taylor series of 30 digits and more.
  [[nodiscard]] static State exact() { return {Vector{-0.42799300494496550972}, Vector{-0.24833927483182805713}}; }
};

}  // namespace problems
