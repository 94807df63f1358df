#define EIGEN_RUNTIME_NO_MALLOC
#include <phistep/linear/dense_inverse.hpp>
#include <phistep/linear/dense_solver.hpp>

#include <type_traits>

#include "linear/dense_battery.hpp"

using phistep::DenseInverse;
using phistep::DenseLu;
using phistep::SmallDenseSolver;
using phistep::Solves;

static_assert(std::is_same_v<SmallDenseSolver<double, 3, Solves::few>, DenseLu<double, 3>>);
static_assert(std::is_same_v<SmallDenseSolver<double, 4, Solves::few>, DenseInverse<double, 4>>);
static_assert(std::is_same_v<SmallDenseSolver<double, 9, Solves::few>, DenseLu<double, 9>>);
static_assert(std::is_same_v<SmallDenseSolver<double, 3, Solves::several>, DenseInverse<double, 3>>);
static_assert(std::is_same_v<SmallDenseSolver<double, 20, Solves::several>, DenseLu<double, 20>>);
static_assert(std::is_same_v<SmallDenseSolver<float, 32, Solves::many>, DenseInverse<float, 32>>);
static_assert(std::is_same_v<SmallDenseSolver<double, 33, Solves::many>, DenseLu<double, 33>>);
static_assert(std::is_same_v<SmallDenseSolver<double, Eigen::Dynamic, Solves::many>, DenseLu<double, Eigen::Dynamic>>);

// Each column of X has a residual of at most 8 n u |L||U||U⁻¹||U||X| (Higham, Accuracy and Stability of Numerical
// Algorithms, 2nd ed., theorem 14.5), and the product X b adds n u |A||X||b|, which is smaller.
TEMPLATE_TEST_CASE("the inverse solves to the rounding of its elimination", "", float, double, long double) {
  dense::for_each_size<TestType>([](auto n) {
    dense::solves<DenseInverse<TestType, n>>(n, [](const auto& A, auto& solver, const auto& b, const auto&) {
      const dense::Matrix X = solver.matrix().template cast<long double>();
      return dense::Vector(dense::Elimination(A).gauss_jordan * (X.cwiseAbs() * b.cwiseAbs()));
    });
  });
}

TEMPLATE_TEST_CASE("the inverse of a singular matrix is refused", "", float, double, long double) {
  dense::for_each_size<TestType>([](auto n) { dense::refuses_singular<DenseInverse<TestType, n>>(n); });
}

TEMPLATE_TEST_CASE("the inverse of a matrix with one bad entry is refused", "", float, double, long double) {
  dense::for_each_size<TestType>([](auto n) { dense::refuses_non_finite<DenseInverse<TestType, n>>(n); });
}

TEMPLATE_TEST_CASE("the inverse multiplies in place", "", float, double, long double) {
  dense::for_each_size<TestType>([](auto n) { dense::solves_where_x_lies<DenseInverse<TestType, n>>(n); });
}

TEST_CASE("matrix() becomes the inverse itself") {
  DenseInverse<double, 4> solver;
  solver.matrix() << 0, 2, 0, 0, 0, 0, 4, 0, 8, 0, 0, 0, 0, 0, 0, 16;
  const Eigen::Matrix4d A = solver.matrix();
  REQUIRE(solver.factorize());
  CHECK(A * solver.matrix() == Eigen::Matrix4d::Identity());
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
