#define EIGEN_RUNTIME_NO_MALLOC
#include "step/matrix/dense_lu_cases.hpp"

using namespace dense_lu_cases;

TEMPLATE_TEST_CASE("LU solves to rounding", "", float, double, long double) {
  dense::for_sizes<Lu<TestType>::template OfSize>(solves_to_rounding, dense::QuickSizes<TestType>{});
}

TEMPLATE_TEST_CASE("a singular matrix is refused, not divided by zero", "", float, double, long double) {
  dense::for_sizes<Lu<TestType>::template OfSize>(dense::refuses_singular, dense::QuickSizes<TestType>{});
}

TEMPLATE_TEST_CASE("a matrix with one bad entry is refused", "", float, double, long double) {
  dense::for_sizes<Lu<TestType>::template OfSize>(dense::refuses_non_finite, dense::QuickSizes<TestType>{});
}

TEMPLATE_TEST_CASE("LU solves in place", "", float, double, long double) {
  dense::for_sizes<Lu<TestType>::template OfSize>(dense::solves_where_x_lies, dense::QuickSizes<TestType>{});
}

TEST_CASE("LU of a size not known: plain loops, then Eigen's") {
  for (const int n : {5, 14}) {
    const auto make = dense::subject<DenseLu<double, Eigen::Dynamic>>(n);
    dense::solves(n, make, of_elimination);
    dense::refuses_singular(n, make);
    dense::refuses_non_finite(n, make);
  }
}

TEST_CASE("equal rows need no exchange, a larger one does") {
  DenseLu<double, 4> lu;
  lu.matrix() << 1, 0, 0, 0, 1, 1, 0, 0, -1, 0, 2, 0, 0, 0, 3, 8;
  REQUIRE(lu.factorize());
  // Rows 1 and 2 tie with row 0, which stays; below, 3 passes 2: a third pivot of 3 and 8 − … on its right.
  CHECK(lu.matrix()(0, 0) == 1);
  CHECK(lu.matrix()(2, 2) == 3);
  CHECK(lu.matrix()(2, 3) == 8);
  CHECK(lu.matrix()(3, 3) == -16.0 / 3);
}

TEST_CASE("factorizing again after a singular matrix works") {
  DenseLu<double, 2> lu;
  lu.matrix() << 1, 2, 2, 4;
  CHECK_FALSE(lu.factorize());
  lu.matrix() << 0, 2, 4, 0;
  REQUIRE(lu.factorize());
  Eigen::Vector2d x(2, 4);
  lu.solve_in_place(x);
  CHECK(x == Eigen::Vector2d(1, 1));
}

TEST_CASE("factorizing allocates nothing") {
  DenseLu<double, 9> lu;
  lu.matrix() = dense::matrix("permuted", 9, 1, 0, 0).cast<double>();
  Eigen::Matrix<double, 9, 1> x = Eigen::Matrix<double, 9, 1>::Ones();
  Eigen::internal::set_is_malloc_allowed(false);  // from here on Eigen ends the program where it allocates
  const bool done = lu.factorize();
  lu.solve_in_place(x);
  Eigen::internal::set_is_malloc_allowed(true);
  CHECK(done);
}
