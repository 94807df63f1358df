#pragma once

#include <Eigen/Core>

namespace problems {

/// HIRES: eight reactions of a plant's response to light (Schäfer 1975), to t = 321.8122.
struct Hires {
  using State = Eigen::Matrix<double, 8, 1>;
  static constexpr double end = 321.8122;

  [[nodiscard]] static State start() { return State{{1, 0, 0, 0, 0, 0, 0, 0.0057}}; }
  State operator()(const State& y) const {
    const double q = 280 * y[5] * y[7];
    State rate;
    // clang-format off
    rate << -1.71 * y[0] + 0.43 * y[1] + 8.32 * y[2] + 0.0007,
        1.71 * y[0] - 8.75 * y[1],
        -10.03 * y[2] + 0.43 * y[3] + 0.035 * y[4],
        8.32 * y[1] + 1.71 * y[2] - 1.12 * y[3],
        -1.745 * y[4] + 0.43 * y[5] + 0.43 * y[6],
        -q + 0.69 * y[3] + 1.71 * y[4] - 0.43 * y[5] + 0.69 * y[6],
        q - 1.81 * y[6],
        -q + 1.81 * y[6];
    // clang-format on
    return rate;
  }
  [[nodiscard]] Eigen::Matrix<double, 8, 8> jacobian(const State& y) const {
    const double a = 280 * y[7], b = 280 * y[5];
    return Eigen::Matrix<double, 8, 8>{{-1.71, 0.43, 8.32, 0, 0, 0, 0, 0},
                                       {1.71, -8.75, 0, 0, 0, 0, 0, 0},
                                       {0, 0, -10.03, 0.43, 0.035, 0, 0, 0},
                                       {0, 8.32, 1.71, -1.12, 0, 0, 0, 0},
                                       {0, 0, 0, 0, -1.745, 0.43, 0.43, 0},
                                       {0, 0, 0, 0.69, 1.71, -a - 0.43, 0.69, -b},
                                       {0, 0, 0, 0, 0, a, -1.81, b},
                                       {0, 0, 0, 0, 0, -a, 1.81, -b}};
  }

  /// By Radau IIA in quadruple precision; the published values agree to 16 digits.
  [[nodiscard]] static State exact() {
    return State{{7.37131257332554165e-04, 1.44248572631615958e-04, 5.88872974096733866e-05, 1.17565134328312545e-03,
                  2.38635619883094917e-03, 6.23896825274159947e-03, 2.84999839518550093e-03, 2.85000160481449927e-03}};
  }
};

}  // namespace problems
