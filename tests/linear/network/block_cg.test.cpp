#include <phistep/linear/network/edge_operator.hpp>

#include <Eigen/Dense>

#include <cmath>
#include <limits>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

/// A chain of n nodes of mass 1, with springs of stiffness k along x and across alike.
EdgeOperator<double, 2> chain(std::int32_t n, double k) {
  EdgeOperator<double, 2> A;
  for (std::int32_t i = 0; i < n; ++i) {
    A.diagonal.push_back({1, 1, 0, 0});
    A.start.push_back(i);
    if (i + 1 == n) break;
    A.neighbour.push_back(i + 1);
    A.edges.push_back({0, 0, 0, k});
    A.signs.push_back(1);
  }
  A.start.push_back(n - 1);
  return A;
}
using Cg = BlockCg<double, 2>;

}  // namespace

TEST_CASE("a small definite matrix is inverted in place, another is refused") {
  Eigen::Matrix3d A = Eigen::Matrix3d::Identity() * 2 + Eigen::Vector3d(1, 2, 3) * Eigen::Vector3d(1, 2, 3).transpose();
  double columns[3][3];
  for (int b = 0; b < 3; ++b)
    for (int a = 0; a < 3; ++a) columns[b][a] = A(a, b);
  CHECK(invert_definite<3>(columns));
  for (int b = 0; b < 3; ++b)
    for (int a = 0; a < 3; ++a) CHECK(columns[b][a] == Approx(A.inverse()(a, b)).epsilon(1e-14));
  double indefinite[2][2] = {{1, 2}, {2, 1}}, zero[1][1] = {{0}}, unbounded[1][1] = {{HUGE_VAL}},
         nan[1][1] = {{std::numeric_limits<double>::quiet_NaN()}};
  CHECK_FALSE(invert_definite<2>(indefinite));
  CHECK_FALSE(invert_definite<1>(zero));
  CHECK_FALSE(invert_definite<1>(unbounded));
  CHECK_FALSE(invert_definite<1>(nan));
}

TEST_CASE("solves to the tolerance, in no more iterations than there are eigenvalues") {
  const auto A = chain(9, 50.0);
  Cg cg;
  cg.resize(9);
  std::vector<double> largest(9);
  REQUIRE(cg.precondition(A, largest));
  CHECK(largest[0] == 51);
  CHECK(largest[4] == 101);
  for (std::size_t i = 0; i < 9; ++i) cg.residual[i] = {1.0 + static_cast<double>(i * i), -2, 0, 0};
  const auto b = cg.residual;
  REQUIRE(cg.solve(A, 1e-12, 100) == Cg::End::converged);
  CHECK(cg.iterations <= 10);  // nine eigenvalues, and one iteration for rounding
  std::vector<Lanes<double>> y(9);
  for (std::size_t i = 0; i < 9; ++i) y[i] = A.node(i, cg.solution[i]);
  static_cast<void>(A.add_edges(cg.solution.data(), y.data()));
  double error = 0, size = 0;
  for (std::size_t i = 0; i < 9; ++i)
    error += (y[i] - b[i]).matrix().squaredNorm(), size += b[i].matrix().squaredNorm();
  // The recursive residual is below 1e-12; the true one may be off by rounding of ‖A‖‖x‖ ≈ 200 ‖b‖.
  CHECK(std::sqrt(error / size) <= 1e-12 + 200 * 2.2e-16 * 10);
}

TEST_CASE("nothing to solve takes no iteration; the cap ends it; an indefinite matrix is noticed") {
  const auto A = chain(50, 1e6);
  Cg cg;
  cg.resize(50);
  std::vector<double> largest(50);
  REQUIRE(cg.precondition(A, largest));
  CHECK(cg.solve(A, 1e-10, 100) == Cg::End::converged);
  CHECK(cg.iterations == 0);
  CHECK(cg.solution[7].isZero());
  cg.residual[3] = {1, 0, 0, 0};
  CHECK(cg.solve(A, 1e-10, 5) == Cg::End::gave_up);
  CHECK(cg.iterations == 5);

  auto bad = chain(3, -0.4);  // blocks 0.6, 0.2, 0.6: definite each, but the chain is not (det = −0.12)
  Cg small;
  small.resize(3);
  std::vector<double> three(3);
  REQUIRE(small.precondition(bad, three));
  small.residual[0] = {1, 0, 0, 0};
  CHECK(small.solve(bad, 1e-10, 100) == Cg::End::indefinite);
  auto worse = chain(3, -0.6);  // the middle block is −0.2
  CHECK_FALSE(small.precondition(worse, three));
}

TEST_CASE("a heavy node's large force doesn't hide what is left to do on light ones") {
  auto A = chain(9, 50.0);
  A.diagonal[0] = {1e12, 1e12, 0, 0};
  Cg cg;
  cg.resize(9);
  std::vector<double> largest(9);
  REQUIRE(cg.precondition(A, largest));
  for (std::size_t i = 0; i < 9; ++i) cg.residual[i] = {i == 0 ? 3e7 : 1.0, 0, 0, 0};
  const auto b = cg.residual;
  constexpr double rtol = 1e-3;  // a single iteration leaves that of the heavy one, and all of the others
  REQUIRE(cg.solve(A, rtol, 100) == Cg::End::converged);
  std::vector<Lanes<double>> y(9);
  for (std::size_t i = 0; i < 9; ++i) y[i] = A.node(i, cg.solution[i]);
  static_cast<void>(A.add_edges(cg.solution.data(), y.data()));
  // Σ r²/d ≤ rtol² Σ b²/d, where d is 1e12 for the heavy node, 51 for the last one and 101 for the others.
  double left = 0, light = 0;
  for (std::size_t i = 1; i < 9; ++i) left += (y[i] - b[i]).matrix().squaredNorm(), light += 1.0 / (i < 8 ? 101 : 51);
  CHECK(std::sqrt(left) <= 1.001 * rtol * std::sqrt(101 * (900 + light)));
}
