#pragma once

#include <Eigen/Core>

#include "problems/entries.hpp"

namespace problems {

/// Van der Pol's relaxation oscillation, y₁' = y₂, ε y₂' = (1 − y₁²) y₂ − y₁ with ε = 1e-6, from (2, −0.66) to t = 2 (Hairer
/// & Wanner, Solving ODEs II, sect. IV.10): two slow branches and two jumps of length 1e-6 between them.
struct Relaxation {
  using State = Eigen::Vector2d;
  static constexpr double fast = 1e6, end = 2;  // fast = 1/ε

  [[nodiscard]] static State start() { return {2, -0.66}; }
  template <class Y, class Out>
  static void rate(const Y& y, Out&& out) {
    out[0] = y[1], out[1] = fast * ((1 - y[0] * y[0]) * y[1] - y[0]);
  }
  template <class Y, class Put>
  static constexpr void entries(const Y& y, Put&& put) {
    put(1, 0, fast * (-2 * y[0] * y[1] - 1)), put(0, 1, 1.0), put(1, 1, fast * (1 - y[0] * y[0]));
  }
  State operator()(const State& y) const {
    State out;
    rate(y, out);
    return out;
  }
  [[nodiscard]] Eigen::Matrix2d jacobian(const State& y) const { return dense_jacobian<Relaxation>(y); }

  /// At t = 2, by Radau IIA in quadruple precision.
  [[nodiscard]] static State exact() { return {1.70616743754319544e+00, -8.92810016551099372e-01}; }
};

}  // namespace problems
