#define EIGEN_RUNTIME_NO_MALLOC
#include "step/matrix/dense_inverse_cases.hpp"
//
#include <phistep/step/matrix/dense_solver.hpp>

#include <type_traits>

using namespace dense_inverse_cases;
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

TEMPLATE_TEST_CASE("the inverse solves to the rounding of its elimination", "", float, double, long double) {
  dense::for_sizes<Inverse<TestType>::template OfSize>(solves_to_rounding, dense::QuickSizes<TestType>{});
}

TEMPLATE_TEST_CASE("the inverse of a singular matrix is refused", "", float, double, long double) {
  dense::for_sizes<Inverse<TestType>::template OfSize>(dense::refuses_singular, dense::QuickSizes<TestType>{});
}

TEMPLATE_TEST_CASE("the inverse of a matrix with one bad entry is refused", "", float, double, long double) {
  dense::for_sizes<Inverse<TestType>::template OfSize>(dense::refuses_non_finite, dense::QuickSizes<TestType>{});
}

TEMPLATE_TEST_CASE("the inverse multiplies in place", "", float, double, long double) {
  dense::for_sizes<Inverse<TestType>::template OfSize>(dense::solves_where_x_lies, dense::QuickSizes<TestType>{});
}

TEST_CASE("matrix() becomes the inverse itself") {
  DenseInverse<double, 4> solver;
  solver.matrix() << 0, 2, 0, 0, 0, 0, 4, 0, 8, 0, 0, 0, 0, 0, 0, 16;
  const Eigen::Matrix4d A = solver.matrix();
  REQUIRE(solver.factorize());
  CHECK(A * solver.matrix() == Eigen::Matrix4d::Identity());
}

TEST_CASE("inverting allocates nothing") {
  DenseInverse<double, 9> solver;
  solver.matrix() = dense::matrix("permuted", 9, 1, 0, 0).cast<double>();
  Eigen::Matrix<double, 9, 1> x = Eigen::Matrix<double, 9, 1>::Ones();
  Eigen::internal::set_is_malloc_allowed(false);  // from here on Eigen ends the program where it allocates
  const bool done = solver.factorize();
  solver.solve_in_place(x);
  Eigen::internal::set_is_malloc_allowed(true);
  CHECK(done);
}
