#pragma once

#include <Eigen/Core>

namespace problems {

/// Robertson's three reactions: rates 0.04, 1e4 and 3e7; from (1, 0, 0) to t = 40.
struct Robertson {
  using State = Eigen::Vector3d;
  static constexpr double end = 40;

  [[nodiscard]] static State start() { return {1, 0, 0}; }
  State operator()(const State& y) const {
    const double a = 0.04 * y[0], b = 1e4 * y[1] * y[2], c = 3e7 * y[1] * y[1];
    return {-a + b, a - b - c, c};
  }
  [[nodiscard]] Eigen::Matrix3d jacobian(const State& y) const {
    const double b1 = 1e4 * y[2], b2 = 1e4 * y[1], c1 = 6e7 * y[1];
    return Eigen::Matrix3d{{-0.04, b1, b2}, {0.04, -b1 - c1, -b2}, {0, c1, 0}};
  }

  /// At t = 40, by Radau IIA of 9 and 11 stages in quadruple precision, which agree in all digits.
  [[nodiscard]] static State exact() {
    return {7.15827068719405046e-01, 9.18553476455776429e-06, 2.84163745745830365e-01};
  }
  /// What the components are measured by: y₂ lives at 1e-5.
  [[nodiscard]] static State scale() { return {1, 1e-5, 1}; }
};

}  // namespace problems
