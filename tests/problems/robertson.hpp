#pragma once

#include <Eigen/Core>

#include "problems/entries.hpp"

namespace problems {

/// Robertson's three reactions: rates 0.04, 1e4 and 3e7; from (1, 0, 0) to t = 40, or to 1e11, near its end.
struct Robertson {
  using State = Eigen::Vector3d;
  static constexpr double end = 40, late = 1e11;

  [[nodiscard]] static State start() { return {1, 0, 0}; }
  template <class Y, class Out>
  static void rate(const Y& y, Out&& out) {
    const auto a = 0.04 * y[0], b = 1e4 * y[1] * y[2], c = 3e7 * y[1] * y[1];
    out[0] = -a + b, out[1] = a - b - c, out[2] = c;
  }
  template <class Y, class Put>
  static constexpr void entries(const Y& y, Put&& put) {
    const auto b1 = 1e4 * y[2], b2 = 1e4 * y[1], c1 = 6e7 * y[1];
    put(0, 0, -0.04), put(1, 0, 0.04);
    put(0, 1, b1), put(1, 1, -b1 - c1), put(2, 1, c1);
    put(0, 2, b2), put(1, 2, -b2);
  }
  State operator()(const State& y) const {
    State out;
    rate(y, out);
    return out;
  }
  [[nodiscard]] Eigen::Matrix3d jacobian(const State& y) const { return dense_jacobian<Robertson>(y); }

  /// At t = 40, by Radau IIA of 9 and 11 stages in quadruple precision, which agree in all digits.
  [[nodiscard]] static State exact() {
    return {7.15827068719405046e-01, 9.18553476455776429e-06, 2.84163745745830365e-01};
  }
  /// At t = 1e11, likewise. The printed lists differ from it and from each other in the 15th digit.
  [[nodiscard]] static State exact_late() {
    return {2.08334014970129409e-08, 8.33336077033478378e-14, 9.99999979166515174e-01};
  }
  /// What the components are measured by: y₂ lives at 1e-5.
  [[nodiscard]] static State scale() { return {1, 1e-5, 1}; }
};

}  // namespace problems
