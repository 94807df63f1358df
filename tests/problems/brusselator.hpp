#pragma once

#include <Eigen/Core>

namespace problems {

/// Two reactants around a limit cycle of period 7.2 (Hairer, Norsett & Wanner, Solving ODEs I, sect. II.4, A = 1, B = 3).
struct Brusselator {
  using State = Eigen::Vector2d;
  static constexpr double A = 1, B = 3, end = 20;

  [[nodiscard]] static State start() { return {1.5, 3}; }
  State operator()(const State& y) const {
    const double q = y[0] * y[0] * y[1];
    return {A + q - (B + 1) * y[0], B * y[0] - q};
  }
  [[nodiscard]] Eigen::Matrix2d jacobian(const State& y) const {
    const double p = 2 * y[0] * y[1], q = y[0] * y[0];
    return Eigen::Matrix2d{{p - (B + 1), q}, {B - p, -q}};
  }

  /// At t = 20, by the extrapolated midpoint rule in quadruple precision with 2000 and 4000 steps.
  [[nodiscard]] static State exact() { return {0.49863707126834784865, 4.5967803494520111832}; }
};

}  // namespace problems
