// What block_tridiagonal_lu.test.cpp and block_tridiagonal_lu.full.cpp share.
#pragma once

#include <phistep/linear/block_tridiagonal_lu.hpp>

#include <cmath>
#include <cstdlib>

#include "support/catch.hpp"

using phistep::BlockTridiagonalLu;
using Index = Eigen::Index;
using Mat = Eigen::MatrixXd;
using Vec = Eigen::VectorXd;

namespace block_tridiagonal_lu_cases {

template <int b>
struct Size {
  static constexpr int value = b;
};

/// A random chain; `dominance` is added to the diagonal.
template <int b>
Mat fill(BlockTridiagonalLu<double, b>& lu, double dominance) {
  const Index blocks = lu.blocks();
  Mat A = Mat::Zero(b * blocks, b * blocks);
  for (Index k = 0; k < blocks; ++k) {
    lu.diagonal(k).setRandom();
    lu.diagonal(k).diagonal().array() += dominance;
    lu.lower(k).setRandom();
    lu.upper(k).setRandom();
    A.block<b, b>(b * k, b * k) = lu.diagonal(k);
    if (k > 0) A.block<b, b>(b * k, b * (k - 1)) = lu.lower(k);
    if (k + 1 < blocks) A.block<b, b>(b * k, b * (k + 1)) = lu.upper(k);
  }
  return A;
}
template <int b>
double backward_error(const BlockTridiagonalLu<double, b>& lu, const Mat& A) {
  const Vec rhs = Vec::LinSpaced(A.rows(), -1, 2);
  Vec x = rhs;
  lu.solve_in_place(x.data());
  return (A * x - rhs).norm() / (A.norm() * x.norm() + rhs.norm());
}

}  // namespace block_tridiagonal_lu_cases
