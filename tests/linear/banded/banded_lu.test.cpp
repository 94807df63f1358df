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

using namespace banded_lu_cases;

#if PHISTEP_QUICK

TEMPLATE_TEST_CASE("solves A x = b for any band, where rows must change places too", "", double) {
  check_any_band<TestType>();
}

TEST_CASE("dominant bands keep their rows in place: the narrow ones have loops of their own") {
  for (const Index n : {1, 2, 3, 4, 5, 50})
    for (const Index width : {0, 1, 2, 3}) {
      if (width >= n) continue;
      BandedLu<double> lu;
      lu.resize(n, width, width);
      for (int again = 0; again < 2; ++again) {
        Mat<double> A = random_band<double>(n, width, width);
        A.diagonal().array() += 8;
        fill(lu, A);
        CAPTURE(n, width);
        REQUIRE(lu.factorize());
        check_solves(lu, A);
      }
    }
}

TEST_CASE("equals Eigen's dense LU on a matrix without a usable diagonal") {
  // Ones beside the diagonal, zeros on it: regular for even n, and every pivot comes from another row.
  constexpr Index n = 100;
  Mat<double> A = Mat<double>::Zero(n, n);
  for (Index i = 0; i + 1 < n; ++i) A(i, i + 1) = 1 + 0.01 * static_cast<double>(i), A(i + 1, i) = 2;
  BandedLu<double> lu;
  lu.resize(n, 1, 1);
  fill(lu, A);
  REQUIRE(lu.factorize());
  const Vec<double> b = Vec<double>::LinSpaced(n, -1, 1);
  Vec<double> x = b;
  lu.solve_in_place(x);
  CHECK((A * x - b).norm() <= 1e-14 * A.norm() * x.norm());
}

TEST_CASE("a singular band matrix is refused, wherever its pivot vanishes") {
  constexpr Index n = 9;
  BandedLu<double> lu;
  lu.resize(n, 1, 2);
  lu.clear();
  CHECK_FALSE(lu.factorize());
  for (Index hole = 0; hole < n; ++hole) {
    lu.clear();
    for (Index j = 0; j < n; ++j) lu.column(j)[0] = j == hole ? 0 : 1;
    CAPTURE(hole);
    CHECK_FALSE(lu.factorize());
  }
  // Two equal rows.
  lu.resize(2, 1, 1);
  fill(lu, Mat<double>(Mat<double>::Ones(2, 2)));
  CHECK_FALSE(lu.factorize());
  fill(lu, Mat<double>((Mat<double>(2, 2) << 0, 2, 4, 0).finished()));  // and works again
  REQUIRE(lu.factorize());
  Vec<double> x = Eigen::Vector2d(2, 4);
  lu.solve_in_place(x);
  CHECK(x == Eigen::Vector2d(1, 1));
}

TEST_CASE("a band matrix with one bad entry is refused, or its solution tells") {
  constexpr Index n = 7;
  BandedLu<double> lu;
  lu.resize(n, 2, 1);
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL})
    for (Index j = 0; j < n; ++j)
      for (Index i = std::max<Index>(0, j - 1); i < std::min(n, j + 3); ++i) {
        Mat<double> A = Mat<double>::Identity(n, n);
        A(i, j) = bad;
        fill(lu, A);
        Vec<double> x = Vec<double>::Ones(n);
        const bool accepted = lu.factorize();
        if (accepted) lu.solve_in_place(x);
        CAPTURE(i, j, bad);
        CHECK_FALSE((accepted && x.allFinite()));
      }
}

TEST_CASE("a pivot too small to be inverted counts as zero") {
  BandedLu<double> lu;
  lu.resize(1, 0, 0);
  lu.column(0)[0] = 1e-310;
  CHECK_FALSE(lu.factorize());
}

TEST_CASE("the empty band matrix is regular") {
  BandedLu<double> lu;
  lu.resize(0, 0, 0);
  CHECK(lu.factorize());
}

#elif PHISTEP_FULL

TEMPLATE_TEST_CASE("solves A x = b for any band, where rows must change places too", "", float, double, long double) {
  check_any_band<TestType>();
}

#endif
