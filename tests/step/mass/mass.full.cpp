// mass: the full product and what is dear to compile. The quick half is mass.test.cpp.
#include "step/mass/mass_cases.hpp"
//
#include <phistep/sparse.hpp>

namespace {
Eigen::SparseMatrix<double> sparse(const Eigen::MatrixXd& dense) { return dense.sparseView(); }
}  // namespace

using namespace mass_cases;

TEST_CASE("all ways to write the same mass agree") {
  const auto check = [](auto scheme) {
    using Case = SecondOrder<Dynamic>;
    const Eigen::VectorXd each = Eigen::VectorXd::Constant(6, 2.0);
    const Eigen::VectorXd expected = run<Case>(scheme, mass(2.0));
    CHECK(distance(run<Case>(scheme, mass(each)), expected) <= 1e-13);
    CHECK(distance(run<Case>(scheme, mass(Eigen::MatrixXd(each.asDiagonal()))), expected) <= 1e-13);
    CHECK(distance(run<Case>(scheme, mass(sparse(each.asDiagonal()))), expected) <= 1e-13);
    CHECK(distance(run<Case>(scheme, mass(1.0)), run<Case>(scheme)) <= 1e-13);
    CHECK(distance(run<Case>(scheme, mass(1.0)), expected) > 0.01);
  };
  check(forward_euler), check(trapezoidal), check(velocity_verlet);  // explicit, Newton, Verlet's local solve
}
