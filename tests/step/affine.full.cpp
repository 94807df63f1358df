// Affine forces as dense, sparse and local matrices, and long runs; the quick half is affine.test.cpp.
#include "step/affine_cases.hpp"

using namespace affine_cases;

TEST_CASE("an affine run factorizes once and solves once a step") {
  const Vec theta = Vec::LinSpaced(20, 1, 2);
  const Y motion{theta, -theta};
  const auto exact = [](const Statistics& s, int force_calls) {
    CHECK(s.factorizations == 1);
    CHECK(s.jacobians == 1);
    CHECK(s.solves == steps);
    CHECK(s.iterations == 0);
    CHECK(s.force_calls == force_calls);
  };
  const Mat dense = rod(20);
  const auto f = [dense](const Vec& x) -> Vec { return dense * x; };
  SECTION("first order, as matrices") {
    // φ = ½ needs Ψ(y) alone: it is Ψ at the start of the solve, too.
    exact(run(theta, linear(rod(20)), trapezoidal), steps + looks);
    exact(run(theta, linear(dense), trapezoidal), steps + looks);
    exact(run(theta, linear(rod(20)), backward_euler), steps + looks);
    exact(run(theta, linear(rod(20)), midpoint), steps + looks);
    CHECK(run(theta, linear(rod(20)), trapezoidal).analyses == 1);
  }
  SECTION("first order, by a promise and differences: 20 calls for the Jacobian") {
    exact(run(theta, affine(f), trapezoidal), steps + looks + 20);
  }
  SECTION("motion") {
    exact(run(motion, linear(Mat(-4 * Mat::Identity(20, 20))), trapezoidal), 2 * steps + looks);
    exact(run(motion, linear(Mat(-4 * Mat::Identity(20, 20))), midpoint), steps + looks);
    exact(run(motion, linear(rod(20), Eigen::SparseMatrix<double>(0.1 * rod(20))), backward_euler), steps + looks);
  }
  SECTION("stiff motion starts from its position: one call more where that is found out") {
    exact(run(motion, linear(Mat(1e4 * dense)), backward_euler), steps + looks + 1);
    exact(run(motion, linear(Mat(1e4 * dense)), phi_stage(0.6)), steps + looks + 1);
    exact(run(motion, linear(Mat(1e5 * dense)), midpoint), steps + looks + 1);
  }
  SECTION("a sum of affine terms is affine") {
    exact(run(motion, linear(rod(20)) + LinearDrag{0.1} + Gravity{Eigen::Matrix<double, 1, 1>(-9.81)}, midpoint),
          steps + looks);
  }
  SECTION("a load that changes in time leaves the matrix alone") {
    exact(run(theta, Driven{}, trapezoidal), 2 * steps + looks);
  }
  SECTION("a solver of one's own") {
    exact(run(theta, linear(rod(20)), backward_euler, newton<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>()),
          steps + looks);
  }
  SECTION("fixed sizes") {
    const Eigen::Vector3d small(1, 2, 3);
    exact(run(small, linear(Eigen::Matrix3d(-Eigen::Matrix3d::Identity())), trapezoidal), steps + looks);
  }
}
