#pragma once

#include <Eigen/Core>

#include <cmath>

namespace problems {

/// A pendulum with quadratic drag, as a flow.
template <class T>
struct PendulumFlow {
  using Two = Eigen::Matrix<T, 2, 1>;
  Two operator()(const Two& y) const {
    using std::sin;
    return {y[1], -2 * sin(y[0]) - y[1] - y[1] * y[1] / 4};
  }
  [[nodiscard]] Eigen::Matrix<T, 2, 2> jacobian(const Two& y) const {
    using std::cos;
    return Eigen::Matrix<T, 2, 2>{{T(0), T(1)}, {-2 * cos(y[0]), -1 - y[1] / 2}};
  }
};

}  // namespace problems
