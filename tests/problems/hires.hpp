#pragma once

#include <Eigen/Core>

#include "problems/entries.hpp"

namespace problems {

/// HIRES: eight reactions of a plant's response to light (Schäfer 1975), to t = 321.8122.
struct Hires {
  using State = Eigen::Matrix<double, 8, 1>;
  static constexpr double end = 321.8122;

  [[nodiscard]] static State start() { return State{{1, 0, 0, 0, 0, 0, 0, 0.0057}}; }
  template <class Y, class Out>
  static void rate(const Y& y, Out&& out) {
    const auto q = 280 * y[5] * y[7];
    out[0] = -1.71 * y[0] + 0.43 * y[1] + 8.32 * y[2] + 0.0007;
    out[1] = 1.71 * y[0] - 8.75 * y[1];
    out[2] = -10.03 * y[2] + 0.43 * y[3] + 0.035 * y[4];
    out[3] = 8.32 * y[1] + 1.71 * y[2] - 1.12 * y[3];
    out[4] = -1.745 * y[4] + 0.43 * y[5] + 0.43 * y[6];
    out[5] = -q + 0.69 * y[3] + 1.71 * y[4] - 0.43 * y[5] + 0.69 * y[6];
    out[6] = q - 1.81 * y[6];
    out[7] = -q + 1.81 * y[6];
  }
  template <class Y, class Put>
  static constexpr void entries(const Y& y, Put&& put) {
    const auto a = 280 * y[7], b = 280 * y[5];
    put(0, 0, -1.71), put(1, 0, 1.71);
    put(0, 1, 0.43), put(1, 1, -8.75), put(3, 1, 8.32);
    put(0, 2, 8.32), put(2, 2, -10.03), put(3, 2, 1.71);
    put(2, 3, 0.43), put(3, 3, -1.12), put(5, 3, 0.69);
    put(2, 4, 0.035), put(4, 4, -1.745), put(5, 4, 1.71);
    put(4, 5, 0.43), put(5, 5, -a - 0.43), put(6, 5, a), put(7, 5, -a);
    put(4, 6, 0.43), put(5, 6, 0.69), put(6, 6, -1.81), put(7, 6, 1.81);
    put(5, 7, -b), put(6, 7, b), put(7, 7, -b);
  }
  State operator()(const State& y) const {
    State out;
    rate(y, out);
    return out;
  }
  [[nodiscard]] Eigen::Matrix<double, 8, 8> jacobian(const State& y) const { return dense_jacobian<Hires>(y); }

  /// By Radau IIA in quadruple precision; the published values agree to 16 digits.
  [[nodiscard]] static State exact() {
    return State{{7.37131257332554165e-04, 1.44248572631615958e-04, 5.88872974096733866e-05, 1.17565134328312545e-03,
                  2.38635619883094917e-03, 6.23896825274159947e-03, 2.84999839518550093e-03, 2.85000160481449927e-03}};
  }
};

}  // namespace problems
