// W between its own triangular factors: the factors are the formula's, conjugate gradients the same iterates as with the factors
// themselves, and BiCGSTAB ends where it says.
#include <phistep/linear/krylov/eisenstat.hpp>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "linear/krylov/grid.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

/// Masses that differ.
Sparse uneven(Eigen::Index m, int dim, double gamma) {
  return grid(m, dim, gamma, [](Eigen::Index i) { return 1 + 0.3 * static_cast<double>(i % 5); });
}
/// The same with its unknowns in a random order.
Sparse shuffled(const Sparse& W) {
  Eigen::PermutationMatrix<Eigen::Dynamic> P(W.rows());
  std::iota(P.indices().data(), P.indices().data() + W.rows(), 0);
  std::shuffle(P.indices().data(), P.indices().data() + W.rows(), std::mt19937{7});
  Sparse out = P * W * P.transpose();
  out.makeCompressed();
  return out;
}
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
/// (D + L) D⁻¹ (D + U) by (1) of eisenstat.hpp, as it stands there.
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

struct ByFactors {
  const Sparse& W;
  Vec w;
  Eigen::PartialPivLU<Mat> p{factors(W)};
  void multiply(const Vec& x, Vec& out) const { out = W * x; }
  void precondition(const Vec& x, Vec& out) const { out = p.solve(x); }
  [[nodiscard]] const Vec& weights() const { return w; }
};
using Two = Eisenstat<double>;

}  // namespace

TEST_CASE("conjugate gradients with the factors themselves take the same iterations to the same x") {
  for (const Sparse& W : {uneven(24, 2, 0.1), uneven(9, 3, 0.1), shuffled(uneven(24, 2, 0.1)), uneven(24, 2, 1e-6)}) {
    const Eigen::Index n = W.rows();
    const Vec b = Vec::LinSpaced(n, 0, 40).array().sin(), w = Vec::LinSpaced(n, 0.5, 3);
    ByFactors by{W, w};
    KrylovIteration<double, KrylovMethod::conjugate_gradients> cg;
    cg.resize(n);
    Two two;
    REQUIRE(two.analyze(W));
    REQUIRE(two.factorize(W));
    for (const KrylovGoal goal :
         {KrylovGoal{.absolute = 1e9}, KrylovGoal{.absolute = 1e-3}, KrylovGoal{.absolute = 1e-9},
          KrylovGoal{.absolute = 1e-9, .max_iterations = 3}, KrylovGoal{.relative = 1e-5}}) {
      Vec r = b, x = Vec::Zero(n), y = b;
      const KrylovEnd usual = cg.solve(by, goal, r, x);
      const KrylovEnd end = two.solve_within(goal, y, [&w](Vec& to) { to = w; });
      CAPTURE(n, goal.absolute, goal.relative, end.iterations);
      CHECK(end.iterations == usual.iterations);
      CHECK(end.converged == usual.converged);
      // Roundings separate two runs of many iterations, but not beyond what is left of the error.
      CHECK((x - y).norm() <=
            1e-12 * x.norm() + (end.converged ? 1e-2 * std::min(goal.absolute, 1e-9) * std::sqrt(n) : 0));
      if (goal.absolute > 1) CHECK(y.isZero(0));
    }
    Vec r = b, x = Vec::Constant(n, 2);
    CHECK(two.solve({.relative = 1e-12}, r, x).converged);
    CHECK((W * (x - Vec::Constant(n, 2)) - b).norm() <= 1e-10 * b.norm());
    Vec z = b;
    two.precondition(z);
    CHECK((z - by.p.solve(b)).norm() <= 1e-13 * z.norm());
    Vec zero = Vec::Zero(n);
    CHECK(two.solve_within({.absolute = 1e-9}, zero, [&w](Vec& to) { to = w; }).iterations == 0);
    CHECK(zero.isZero(0));
  }
}

TEST_CASE("one that was made for another W of the same pattern is made anew") {
  const Sparse first = uneven(12, 2, 1), W = uneven(12, 2, 1e-3);
  Two two;
  REQUIRE(two.analyze(first));
  REQUIRE(two.factorize(first));
  REQUIRE(two.factorize(W));
  const Vec exact = Vec::LinSpaced(W.rows(), -1, 2);
  Vec r = W * exact, x = Vec::Zero(W.rows());
  REQUIRE(two.solve({.relative = 1e-13}, r, x).converged);
  CHECK((x - exact).norm() <= 1e-11 * exact.norm());
}

TEST_CASE(
    "unsymmetric, also where the wind rules or the pattern has triangles: P is the formula's, x as good as asked for") {
  for (const Sparse& W : {windy(12, 10, 0.2), windy(12, 100, 0.2), windy(12, 10, 5), windy(12, 10, 0.5, true)}) {
    Eisenstat<double> two;
    REQUIRE(two.analyze(W));
    REQUIRE(two.factorize(W));
    CHECK_FALSE(two.is_symmetric());
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

TEST_CASE("turned symmetric or unsymmetric: at once the other method") {
  const Sparse W = grid(20, 2, 0.1, [](Eigen::Index) { return 1.0; }), other = windy(20, 10, 0.3);
  const Vec b = Vec::LinSpaced(400, 0, 40).array().sin();
  const auto weigh = [](Vec& to) { to.setOnes(); };
  Eisenstat<double> two;
  REQUIRE(two.analyze(W));
  Vec first;
  for (int round = 0; round < 2; ++round) {
    REQUIRE(two.factorize(W));
    CHECK(two.is_symmetric());
    Vec y = b;
    CHECK(two.solve_within({.absolute = 1e-6}, y, weigh).converged);
    if (round == 0) first = y;
    CHECK((first.array() == y.array()).all());
    REQUIRE(two.factorize(other));
    CHECK_FALSE(two.is_symmetric());
    Vec z = b;
    CHECK(two.solve_within({.absolute = 1e-6}, z, weigh).converged);
    CHECK((other * z - b).norm() <= 1e-3 * b.norm());
  }
}

TEST_CASE("what it does not serve: an unsymmetric pattern, a diagonal with a gap or an entry that isn't positive") {
  Eisenstat<double> two;
  Sparse W = windy(4, 1, 0.5);
  Sparse lacking = W;
  lacking.coeffRef(0, 1) = 0;
  lacking.prune(0.0);
  CHECK_FALSE(two.analyze(lacking));
  Mat no_diagonal = Mat::Identity(3, 3);
  no_diagonal(1, 1) = 0;
  CHECK_FALSE(two.analyze(no_diagonal.sparseView()));
  REQUIRE(two.analyze(W));
  W.coeffRef(5, 5) = -1;
  CHECK_FALSE(two.factorize(W));
}

TEST_CASE(
    "conjugate gradients need fewer iterations than by plain incomplete factors, and the more so the larger the grid") {
  const auto with_plain = [](const Sparse& W, Vec r) {
    Eigen::ConjugateGradient<Sparse, Eigen::Lower,
                             Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::NaturalOrdering<int>>>
        cg(W);
    cg.setTolerance(1e-8);
    r = cg.solve(r).eval();
    return static_cast<int>(cg.iterations());
  };
  const auto iterations = [](const Sparse& W, const Vec& b) {
    Eisenstat<double> two;
    REQUIRE((two.analyze(W) && two.factorize(W)));
    Vec r = b, x = Vec::Zero(b.size());
    const KrylovEnd end = two.solve({.relative = 1e-8}, r, x);
    REQUIRE(end.converged);
    CHECK((W * x - b).norm() <= 1e-6 * b.norm());
    return end.iterations;
  };
  const auto even = [](Eigen::Index m) { return grid(m, 2, 0.1, [](Eigen::Index) { return 1.0; }); };
  const auto right = [](const Sparse& W) -> Vec { return Vec::LinSpaced(W.rows(), 0, 40).array().sin(); };
  const Sparse coarse = even(32), fine = even(128);
  const int a = iterations(coarse, right(coarse)), b = iterations(fine, right(fine));
  CAPTURE(a, b, with_plain(fine, right(fine)));
  CHECK(b <= 2.6 * a);  // four times the side: twice as many
  CHECK(2 * b <= with_plain(fine, right(fine)));
}
