// Dense LU at every size and of every scalar. In short: dense_lu.test.cpp.
#define EIGEN_RUNTIME_NO_MALLOC
#include "step/matrix/dense_lu_cases.hpp"

using namespace dense_lu_cases;

TEMPLATE_TEST_CASE("LU solves to rounding", "", float, double, long double) {
  dense::for_sizes<Lu<TestType>::template OfSize>(solves_to_rounding, dense::Sizes<TestType>{});
}

TEMPLATE_TEST_CASE("a singular matrix is refused, not divided by zero", "", float, double, long double) {
  dense::for_sizes<Lu<TestType>::template OfSize>(dense::refuses_singular, dense::Sizes<TestType>{});
}

TEMPLATE_TEST_CASE("a matrix with one bad entry is refused", "", float, double, long double) {
  dense::for_sizes<Lu<TestType>::template OfSize>(dense::refuses_non_finite, dense::Sizes<TestType>{});
}

TEMPLATE_TEST_CASE("LU solves in place", "", float, double, long double) {
  dense::for_sizes<Lu<TestType>::template OfSize>(dense::solves_where_x_lies, dense::Sizes<TestType>{});
}

// Where n is not known, plain loops for few rows; else, and beyond the limit, Eigen's.
TEST_CASE("LU of sizes not known, and of large ones") {
  const auto check = [](int n, const dense::Make& make) {
    dense::solves(n, make, of_elimination);
    dense::refuses_singular(n, make);
    dense::refuses_non_finite(n, make);
  };
  check(33, dense::subject<DenseLu<double, 33>>(33));
  for (const int n : {1, 2, 5, 12, 13, 23, 32, 33}) check(n, dense::subject<DenseLu<double, Eigen::Dynamic>>(n));
}

TEST_CASE("factorizing allocates nothing") {
  DenseLu<double, 20> lu;
  lu.matrix() = dense::matrix("permuted", 20, 1, 0, 0).cast<double>();
  Eigen::Matrix<double, 20, 1> x = Eigen::Matrix<double, 20, 1>::Ones();
  Eigen::internal::set_is_malloc_allowed(false);  // from here on Eigen ends the program where it allocates
  const bool done = lu.factorize();
  lu.solve_in_place(x);
  Eigen::internal::set_is_malloc_allowed(true);
  CHECK(done);
}

TEST_CASE("the empty matrix is regular") {
  DenseLu<double, Eigen::Dynamic> lu;
  lu.resize(0);
  CHECK(lu.factorize());
}
