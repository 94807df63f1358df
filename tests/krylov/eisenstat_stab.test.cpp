// W between its own triangular factors, unsymmetric: the factors are those of the formula, and BiCGSTAB ends where it says.
#include <phistep/krylov/eisenstat_stab.hpp>

#include <cmath>
#include <vector>

#include "krylov/grid.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

/// Diffusion and a wind along x, on a grid; `wide` with corners, so that neighbours of an unknown are neighbours of each other.
Sparse windy(int m, double gamma, double wind, bool wide = false) {
  Sparse W(m * m, m * m);
  std::vector<Eigen::Triplet<double>> all;
  for (int k = 0; k < m * m; ++k)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int x = k % m + dx, y = k / m + dy;
        const bool corner = dx != 0 && dy != 0;
        if (x < 0 || x >= m || y < 0 || y >= m || (corner && !wide)) continue;
        const double w = dx == 0 && dy == 0 ? 1 + gamma * 4.5 : -gamma * (corner ? 0.1 : 1 - wind * dx);
        all.emplace_back(k, x + m * y, w);
      }
  W.setFromTriplets(all.begin(), all.end());
  return W;
}
/// (D + L) D⁻¹ (D + U) by (1) of eisenstat_form.hpp, as it stands there.
Mat factors(const Sparse& sparse) {
  const Mat W = sparse;
  constexpr double omega = 0.98;
  Vec d(W.rows());
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    d[i] = W(i, i);
    for (Eigen::Index j = 0; j < i; ++j)
      d[i] -= W(j, i) / d[j] * ((1 - omega) * W(i, j) + omega * W.col(j).tail(W.rows() - j - 1).sum());
    if (!(d[i] > W(i, i) / 100)) d[i] = W(i, i);
  }
  Mat lower = W.triangularView<Eigen::StrictlyLower>(), upper = W.triangularView<Eigen::StrictlyUpper>();
  lower.diagonal() = upper.diagonal() = d;
  return lower * d.cwiseInverse().asDiagonal() * upper;
}

}  // namespace

TEST_CASE(
    "unsymmetric, also where the wind rules or the pattern has triangles: P is the formula's, x as good as asked for") {
  for (const Sparse& W : {windy(12, 10, 0.2), windy(12, 100, 0.2), windy(12, 10, 5), windy(12, 10, 0.5, true)}) {
    EisenstatStab<double> two;
    REQUIRE(two.analyze(W));
    REQUIRE(two.factorize(W) == EisenstatStab<double>::Found::unsymmetric);
    const Eigen::Index n = W.rows();
    const Vec b = Vec::LinSpaced(n, 0, 40).array().sin(), w = Vec::LinSpaced(n, 0.5, 3);
    const Eigen::PartialPivLU<Mat> P(factors(W));
    Vec z = b;
    two.precondition(z);
    CHECK((z - P.solve(b)).norm() <= 1e-12 * z.norm());
    const auto size = [&](const Vec& x) {
      return (w.array() * P.solve(b - W * x).array()).matrix().norm() / std::sqrt(static_cast<double>(n));
    };
    for (const double goal : {1e-2, 1e-5, 1e-9}) {
      Vec x = b;
      const KrylovEnd end = two.solve_within({.absolute = goal}, x, [&w](Vec& to) { to = w; });
      CAPTURE(goal, end.iterations);
      CHECK(end.converged);
      CHECK(end.iterations <= 25);
      CHECK(size(x) <= 1.01 * goal);
    }
    Vec r = b, x = Vec::Constant(n, 2);
    CHECK(two.solve({.relative = 1e-12}, r, x).converged);
    CHECK((W * (x - Vec::Constant(n, 2)) - b).norm() <= 1e-9 * b.norm());
    Vec y = b;
    const KrylovEnd cut = two.solve_within({.absolute = 1e-9, .max_iterations = 2}, y, [&w](Vec& to) { to = w; });
    CHECK_FALSE(cut.converged);
    CHECK(cut.iterations == 2);
    Vec zero = Vec::Zero(n);
    CHECK(two.solve_within({.absolute = 1e-9}, zero, [&w](Vec& to) { to = w; }).iterations == 0);
    CHECK(zero.isZero(0));
  }
}

TEST_CASE("symmetric: conjugate gradients, bit by bit; turned symmetric or unsymmetric: at once the other one") {
  const Sparse W = grid(20, 2, 0.1, [](Eigen::Index) { return 1.0; }), other = windy(20, 10, 0.3);
  const Vec b = Vec::LinSpaced(400, 0, 40).array().sin();
  const auto weigh = [](Vec& to) { to.setOnes(); };
  EisenstatCg<double> plain;
  EisenstatStab<double> two;
  REQUIRE((plain.analyze(W) && two.analyze(W)));
  REQUIRE(plain.factorize(W) == EisenstatCg<double>::Found::definite);
  Vec x = b;
  const KrylovEnd by_cg = plain.solve_within({.absolute = 1e-6}, x, weigh);
  for (int round = 0; round < 2; ++round) {
    REQUIRE(two.factorize(W) == EisenstatStab<double>::Found::definite);
    Vec y = b;
    CHECK(two.solve_within({.absolute = 1e-6}, y, weigh).iterations == by_cg.iterations);
    CHECK((x.array() == y.array()).all());
    REQUIRE(two.factorize(other) == EisenstatStab<double>::Found::unsymmetric);
    Vec z = b;
    CHECK(two.solve_within({.absolute = 1e-6}, z, weigh).converged);
    CHECK((other * z - b).norm() <= 1e-3 * b.norm());
  }
}

TEST_CASE("what it does not serve: an unsymmetric pattern, a diagonal that isn't positive") {
  EisenstatStab<double> two;
  Sparse W = windy(4, 1, 0.5);
  Sparse lacking = W;
  lacking.coeffRef(0, 1) = 0;
  lacking.prune(0.0);
  CHECK_FALSE(two.analyze(lacking));
  REQUIRE(two.analyze(W));
  W.coeffRef(5, 5) = -1;
  CHECK(two.factorize(W) == EisenstatStab<double>::Found::indefinite);
}
