#include "linear/banded/banded_lu_cases.hpp"

using namespace banded_lu_cases;

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
