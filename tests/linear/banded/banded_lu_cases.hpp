// What banded_lu.test.cpp and banded_lu.full.cpp share.
#pragma once

#include <phistep/linear/banded/banded_lu.hpp>

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "support/catch.hpp"

using phistep::BandedLu;
using Index = Eigen::Index;

namespace banded_lu_cases {

template <class Scalar>
using Mat = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
template <class Scalar>
using Vec = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

template <class Scalar>
Mat<Scalar> random_band(Index n, Index lower, Index upper) {
  Mat<Scalar> A = Mat<Scalar>::Random(n, n);
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i)
      if (i - j > lower || j - i > upper) A(i, j) = 0;
  return A;
}
template <class Scalar>
void fill(BandedLu<Scalar>& lu, const Mat<Scalar>& A) {
  lu.clear();
  for (Index j = 0; j < A.cols(); ++j)
    for (Index i = std::max<Index>(0, j - lu.upper()); i < std::min(A.rows(), j + lu.lower() + 1); ++i)
      lu.column(j)[i - j] = A(i, j);
}
/// Backward error of a solution: a few n units in the last place, times the growth of partial pivoting (small here).
template <class Scalar>
void check_solves(BandedLu<Scalar>& lu, const Mat<Scalar>& A) {
  const Vec<Scalar> b = Vec<Scalar>::Random(A.rows());
  Vec<Scalar> x = b;
  lu.solve_in_place(x);
  const auto n = static_cast<Scalar>(A.rows());
  CHECK((A * x - b).norm() <= 8 * n * std::numeric_limits<Scalar>::epsilon() * (A.norm() * x.norm() + b.norm()));
}

template <class Scalar>
void check_any_band() {
  for (const Index n : {1, 2, 3, 10, 57})
    for (const Index lower : {0, 1, 2, 5})
      for (const Index upper : {0, 1, 2, 7}) {
        if (lower >= n || upper >= n) continue;
        std::srand(static_cast<unsigned>(100 * lower + 10 * upper + n));
        BandedLu<Scalar> lu;
        lu.resize(n, lower, upper);
        for (int again = 0; again < 3; ++again) {
          CAPTURE(n, lower, upper, again);
          Mat<Scalar> A = random_band<Scalar>(n, lower, upper);
          // A triangular random matrix may be as badly conditioned as it likes: not what is tested.
          if (lower == 0 || upper == 0) A.diagonal().array() += Scalar{8};
          // A zero that pivoting must step around.
          else A(0, 0) = 0;
          fill(lu, A);
          if (n == 1 && A(0, 0) == 0) continue;
          REQUIRE(lu.factorize());
          check_solves(lu, A);
        }
      }
}

}  // namespace banded_lu_cases
