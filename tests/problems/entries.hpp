#pragma once

#include <Eigen/Core>

// Many of the problems have f and ∂f/∂y as templates over what holds y, for anything with []: bare arrays, extended
// precision, C++17.
//     rate(y, out)       out = f(y)
//     entries(y, put)    calls put(i, j, ∂f_i/∂y_j) for what isn't zero, each once, always in the same order

namespace problems {

/// ∂f/∂y, dense.
template <class Problem, class State>
[[nodiscard]] auto dense_jacobian(const State& y) {
  constexpr int n = State::RowsAtCompileTime;
  Eigen::Matrix<typename State::Scalar, n, n> J = Eigen::Matrix<typename State::Scalar, n, n>::Zero();
  Problem::entries(y, [&J](int i, int j, const auto& x) { J(i, j) = x; });
  return J;
}

}  // namespace problems
