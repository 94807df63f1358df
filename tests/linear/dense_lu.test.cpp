#define EIGEN_RUNTIME_NO_MALLOC
#include <phistep/linear/dense_lu.hpp>

#include "linear/dense_battery.hpp"

using phistep::DenseLu;

// Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., theorem 9.4: |A x − b| ≤ γ_3n |L||U||x|.
constexpr auto of_elimination = [](const auto& A, auto&, const auto&, const auto& x) {
  return dense::Vector(dense::Elimination(A).product * x.cwiseAbs());
};
// Without scaling there is next to no growth: |A x − b|_i ≤ c n u Σ_j |a_ij| ‖x‖.
constexpr auto of_rows = [](const auto& A, auto&, const auto&, const auto& x) {
  return dense::Vector(A.cwiseAbs().rowwise().sum() * x.cwiseAbs().maxCoeff());
};

TEMPLATE_TEST_CASE("LU solves to rounding", "", float, double, long double) {
  dense::for_each_size<TestType>([](auto n) {
    dense::solves<DenseLu<TestType, n>>(n, of_elimination);
    dense::solves<DenseLu<TestType, n>>(n, of_rows, false);
  });
}

TEMPLATE_TEST_CASE("a singular matrix is refused, not divided by zero", "", float, double, long double) {
  dense::for_each_size<TestType>([](auto n) { dense::refuses_singular<DenseLu<TestType, n>>(n); });
}

TEMPLATE_TEST_CASE("a matrix with one bad entry is refused", "", float, double, long double) {
  dense::for_each_size<TestType>([](auto n) { dense::refuses_non_finite<DenseLu<TestType, n>>(n); });
}

TEMPLATE_TEST_CASE("LU solves in place", "", float, double, long double) {
  dense::for_each_size<TestType>([](auto n) { dense::solves_where_x_lies<DenseLu<TestType, n>>(n); });
}

// Beyond the limit, and where n is not known: Eigen's.
TEST_CASE("Eigen's LU behind the same door") {
  dense::solves<DenseLu<double, 33>>(33, of_elimination);
  dense::refuses_singular<DenseLu<double, 33>>(33);
  dense::refuses_non_finite<DenseLu<double, 33>>(33);
  for (const int n : {1, 5, 23}) {
    dense::solves<DenseLu<double, Eigen::Dynamic>>(n, of_elimination);
    dense::refuses_singular<DenseLu<double, Eigen::Dynamic>>(n);
    dense::refuses_non_finite<DenseLu<double, Eigen::Dynamic>>(n);
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

TEST_CASE("factorising again after a singular matrix works") {
  DenseLu<double, 2> lu;
  lu.matrix() << 1, 2, 2, 4;
  CHECK_FALSE(lu.factorize());
  lu.matrix() << 0, 2, 4, 0;
  REQUIRE(lu.factorize());
  Eigen::Vector2d x(2, 4);
  lu.solve_in_place(x);
  CHECK(x == Eigen::Vector2d(1, 1));
}

TEST_CASE("factorising allocates nothing") {
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
