// The dense inverse at every size and of every scalar. The quick half is dense_inverse.test.cpp.
#define EIGEN_RUNTIME_NO_MALLOC
#include "step/matrix/dense_inverse_cases.hpp"

using namespace dense_inverse_cases;

TEMPLATE_TEST_CASE("the inverse solves to the rounding of its elimination", "", float, double, long double) {
  dense::for_sizes<Inverse<TestType>::template OfSize>(solves_to_rounding, dense::Sizes<TestType>{});
}

TEMPLATE_TEST_CASE("the inverse of a singular matrix is refused", "", float, double, long double) {
  dense::for_sizes<Inverse<TestType>::template OfSize>(dense::refuses_singular, dense::Sizes<TestType>{});
}

TEMPLATE_TEST_CASE("the inverse of a matrix with one bad entry is refused", "", float, double, long double) {
  dense::for_sizes<Inverse<TestType>::template OfSize>(dense::refuses_non_finite, dense::Sizes<TestType>{});
}

TEMPLATE_TEST_CASE("the inverse multiplies in place", "", float, double, long double) {
  dense::for_sizes<Inverse<TestType>::template OfSize>(dense::solves_where_x_lies, dense::Sizes<TestType>{});
}

TEST_CASE("inverting allocates nothing") {
  DenseInverse<double, 20> solver;
  solver.matrix() = dense::matrix("permuted", 20, 1, 0, 0).cast<double>();
  Eigen::Matrix<double, 20, 1> x = Eigen::Matrix<double, 20, 1>::Ones();
  Eigen::internal::set_is_malloc_allowed(false);  // from here on Eigen ends the program where it allocates
  const bool done = solver.factorize();
  solver.solve_in_place(x);
  Eigen::internal::set_is_malloc_allowed(true);
  CHECK(done);
}
