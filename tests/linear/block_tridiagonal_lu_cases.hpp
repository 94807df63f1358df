// What block_tridiagonal_lu.test.cpp and block_tridiagonal_lu.full.cpp share.
#pragma once

#include <phistep/linear/block_tridiagonal_lu.hpp>

#include <algorithm>
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

template <int b>
void check_chains() {
  for (const Index blocks : {1, 2, 3, 40}) {
    std::srand(static_cast<unsigned>(blocks));
    BlockTridiagonalLu<double, b> lu;
    lu.resize(blocks);
    for (int again = 0; again < 3; ++again) {
      const Mat A = fill(lu, 3.0 * b);
      CAPTURE(blocks, again);
      REQUIRE(lu.factorize());
      CHECK(backward_error(lu, A) <= 1e-15);  // dominant: no growth, a few units in the last place
    }
  }
}

template <int b>
void check_accepted() {
  BlockTridiagonalLu<double, b> lu;
  lu.resize(60);
  int refused = 0;
  double worst = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::srand(seed);
    const Mat A = fill(lu, 0);
    if (!lu.factorize()) ++refused;
    else worst = std::max(worst, backward_error(lu, A));
  }
  CAPTURE(refused, worst);
  CHECK(refused > 0);
  CHECK(worst <= std::pow(2.3e-16, 0.75));
}

}  // namespace block_tridiagonal_lu_cases
