#pragma once

// What static_sparse_system.test.cpp and its full half share.

#include <phistep/phistep.hpp>

#include <stdexcept>
#include <string_view>

#include "support/catch.hpp"

namespace static_sparse_cases {

using namespace phistep;

inline constexpr int n = 10;
using Vec = Eigen::Matrix<double, n, 1>;
using Mat = Eigen::Matrix<double, n, n>;

/// A chain of reactions, the last species turning back to the first at a rate that grows with the middle one.
struct Reactions {
  double rate = 30;
  Vec operator()(const Vec& y) const {
    Vec out = Vec::Zero();
    for (int i = 0; i + 1 < n; ++i) out[i] -= rate * (i + 1) * y[i], out[i + 1] += rate * (i + 1) * y[i];
    const double back = y[n - 1] * (1 + y[4]);
    out[n - 1] -= back, out[0] += back;
    return out;
  }
  Mat derivative(const Vec& y) const {
    Mat J = Mat::Zero();
    for (int i = 0; i + 1 < n; ++i) J(i, i) -= rate * (i + 1), J(i + 1, i) += rate * (i + 1);
    J(n - 1, n - 1) -= 1 + y[4], J(0, n - 1) += 1 + y[4];
    J(n - 1, 4) -= y[n - 1], J(0, 4) += y[n - 1];
    return J;
  }
};
struct Dense : Reactions {
  Mat jacobian(const Vec& y) const { return derivative(y); }
};
struct Named {
  static constexpr auto jacobian_pattern =
      entries({{0, 0}, {1, 0}, {1, 1}, {2, 1}, {2, 2}, {3, 2}, {3, 3}, {4, 3}, {4, 4}, {5, 4}, {5, 5},
               {6, 5}, {6, 6}, {7, 6}, {7, 7}, {8, 7}, {8, 8}, {9, 8}, {9, 9}, {0, 9}, {9, 4}, {0, 4}});
};
struct Returned : Dense, Named {};
struct Added : Named {
  Reactions law;
  static constexpr bool uses_time = false;
  void add(auto, const auto& y, auto& out) const { out.rate += law(y.y); }
  void add_jacobian(auto, const auto& y, auto& sink) const {
    const Mat J = law.derivative(y.y);
    for (const MatrixEntry& e : jacobian_pattern) sink.rate(e.row, e.column, J(e.row, e.column));
  }
};
struct Forgotten : Dense {
  static constexpr auto jacobian_pattern = entries({{1, 0}, {9, 4}});
};
struct ForgottenWhenAdded : Added {
  static constexpr auto jacobian_pattern = Forgotten::jacobian_pattern;
};

struct Conserving : Named {
  static constexpr bool is_affine = true, uses_time = false;
  double error = 0;
  void add(auto, const auto& y, auto& out) const {
    for (int i = 0; i + 1 < n; ++i) out.rate[i] -= y.y[i], out.rate[i + 1] += y.y[i];
  }
  void add_jacobian(auto, const auto&, auto& sink) const {
    for (int i = 0; i + 1 < n; ++i) sink.rate(i, i, -1), sink.rate(i + 1, i, 1 + error);
  }
};

inline Vec start() {
  Vec y = Vec::Constant(0.1);
  y[0] = 1;
  return y;
}

}  // namespace static_sparse_cases
