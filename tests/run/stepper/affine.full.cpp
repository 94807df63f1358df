// Affine forces as dense, sparse and local matrices, and long runs; the quick half is affine.test.cpp.
#include <Eigen/SparseCholesky>

#include <cmath>

#include "run/stepper/affine_rod.hpp"

using namespace affine_cases;

namespace {

Statistics run(auto y, const auto& force, auto scheme, const auto&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  const RunReport report = integrate(stepper, y, {0, steps * 0.01}, fixed(0.01));
  CAPTURE(report.message());
  REQUIRE(report);
  REQUIRE(report.statistics.steps == steps);
  return report.statistics;
}

struct Driven {
  static constexpr bool is_affine = true;
  Vec operator()(const Vec& y, double t) const { return std::sin(t) - 3 * y.array(); }
  Mat jacobian(const Vec& y, double) const { return -3 * Mat::Identity(y.size(), y.size()); }
};

}  // namespace

TEST_CASE("an affine run factorizes once and solves once a step") {
  const Vec theta = Vec::LinSpaced(20, 1, 2);
  const Y motion{theta, -theta};
  const Mat dense = rod(20);
  const auto f = [dense](const Vec& x) -> Vec { return dense * x; };
  SECTION("first order, as matrices") {
    // φ = ½ needs Ψ(y) alone: it is Ψ at the start of the solve, too.
    check_exact(run(theta, linear(rod(20)), trapezoidal), steps + looks);
    check_exact(run(theta, linear(dense), trapezoidal), steps + looks);
    check_exact(run(theta, linear(rod(20)), backward_euler), steps + looks);
    check_exact(run(theta, linear(rod(20)), midpoint), steps + looks);
    CHECK(run(theta, linear(rod(20)), trapezoidal).analyses == 1);
  }
  SECTION("first order, by a promise and differences: 20 calls for the Jacobian") {
    check_exact(run(theta, affine(f), trapezoidal), steps + looks + 20);
  }
  SECTION("motion") {
    check_exact(run(motion, linear(Mat(-4 * Mat::Identity(20, 20))), trapezoidal), 2 * steps + looks);
    check_exact(run(motion, linear(Mat(-4 * Mat::Identity(20, 20))), midpoint), steps + looks);
    check_exact(run(motion, linear(rod(20), Eigen::SparseMatrix<double>(0.1 * rod(20))), backward_euler),
                steps + looks);
  }
  SECTION("stiff motion starts from its position: one call more where that is found out") {
    check_exact(run(motion, linear(Mat(1e4 * dense)), backward_euler), steps + looks + 1);
    check_exact(run(motion, linear(Mat(1e4 * dense)), phi_stage(0.6)), steps + looks + 1);
    check_exact(run(motion, linear(Mat(1e5 * dense)), midpoint), steps + looks + 1);
  }
  SECTION("a sum of affine terms is affine") {
    check_exact(run(motion, linear(rod(20)) + LinearDrag{0.1} + Gravity{Eigen::Matrix<double, 1, 1>(-9.81)}, midpoint),
                steps + looks);
  }
  SECTION("a load that changes in time leaves the matrix alone") {
    check_exact(run(theta, Driven{}, trapezoidal), 2 * steps + looks);
  }
  SECTION("a solver of one's own") {
    check_exact(
        run(theta, linear(rod(20)), backward_euler, newton<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>()),
        steps + looks);
  }
  SECTION("fixed sizes") {
    const Eigen::Vector3d small(1, 2, 3);
    check_exact(run(small, linear(Eigen::Matrix3d(-Eigen::Matrix3d::Identity())), trapezoidal), steps + looks);
  }
}
