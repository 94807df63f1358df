#pragma once

#include <Eigen/Core>

#include "problems/entries.hpp"

namespace problems {

/// E5, four reactions of a pyrolysis (test set of Enright, Hull & Lindberg 1975; Hairer & Wanner, Solving ODEs II, sect.
/// IV.10): concentrations from 1e-3 down to 1e-23 over 13 decades of time. y₂' = y₃' + y₄' is kept to the bit by f₃ = f₂ − f₄.
struct E5 {
  using State = Eigen::Vector4d;
  static constexpr double end = 1e13;

  [[nodiscard]] static State start() { return {1.76e-3, 0, 0, 0}; }
  template <class Y, class Out>
  static void rate(const Y& y, Out&& out) {
    const auto a = 7.89e-10 * y[0], b = 1.1e7 * y[0] * y[2], c = 1.13e9 * y[1] * y[2], d = 1.13e3 * y[3];
    out[0] = -a - b, out[1] = a - c, out[3] = b - d, out[2] = out[1] - out[3];
  }
  template <class Y, class Put>
  static constexpr void entries(const Y& y, Put&& put) {
    constexpr double a = 7.89e-10, d = 1.13e3;
    const auto b1 = 1.1e7 * y[2], b3 = 1.1e7 * y[0], c2 = 1.13e9 * y[2], c3 = 1.13e9 * y[1];
    put(0, 0, -a - b1), put(1, 0, a), put(2, 0, a - b1), put(3, 0, b1);
    put(1, 1, -c2), put(2, 1, -c2);
    put(0, 2, -b3), put(1, 2, -c3), put(2, 2, -c3 - b3), put(3, 2, b3);
    put(2, 3, d), put(3, 3, -d);
  }
  State operator()(const State& y) const {
    State out;
    rate(y, out);
    return out;
  }
  [[nodiscard]] Eigen::Matrix4d jacobian(const State& y) const { return dense_jacobian<E5>(y); }

  /// At t = 1e5, by Radau IIA in long double at rtol from 1e-12 to 1e-16, which agree to 1e-15.
  [[nodiscard]] static State at_1e5() {
    return {7.48132082242932e-06, 2.37347815612061e-12, 2.21235866895818e-12, 1.61119487162434e-13};
  }
  /// At t = 1e11, in quadruple precision.
  [[nodiscard]] static State at_1e11() {
    return {3.76930822529560559e-49, 1.01925825681427061e-20, 1.01925825681427061e-20, 3.73990122497746449e-65};
  }
  /// At t = 1e13, by Radau IIA of 7 and 9 stages in quadruple precision; y₁ and y₄ are below 1e-200. The printed values
  /// violate y₂ = y₃ + y₄ and are off by 7e-4.
  [[nodiscard]] static State exact() { return {0, 8.86123352129108424e-23, 8.86123352129108424e-23, 0}; }
};

}  // namespace problems
