#pragma once

#include <Eigen/Core>

namespace problems {

/// Van der Pol's relaxation oscillation, y₁' = y₂, ε y₂' = (1 − y₁²) y₂ − y₁ with ε = 1e-6, from (2, −0.66) to t = 2 (Hairer
/// & Wanner, Solving ODEs II, sect. IV.10): two slow branches and two jumps of length 1e-6 between them.
struct Relaxation {
  using State = Eigen::Vector2d;
  static constexpr double rate = 1e6, end = 2;  // rate = 1/ε

  [[nodiscard]] static State start() { return {2, -0.66}; }
  State operator()(const State& y) const { return {y[1], rate * ((1 - y[0] * y[0]) * y[1] - y[0])}; }
  [[nodiscard]] Eigen::Matrix2d jacobian(const State& y) const {
    return Eigen::Matrix2d{{0, 1}, {rate * (-2 * y[0] * y[1] - 1), rate * (1 - y[0] * y[0])}};
  }

  /// At t = 2, by Radau IIA in quadruple precision.
  [[nodiscard]] static State exact() { return {1.70616743754319544e+00, -8.92810016551099372e-01}; }
};

}  // namespace problems
