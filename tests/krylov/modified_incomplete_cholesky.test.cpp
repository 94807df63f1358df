// Incomplete factors that keep row sums: exact where nothing is dropped, and what they spare on grids.
#include <phistep/krylov/methods.hpp>
#include <phistep/krylov/modified_incomplete_cholesky.hpp>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/LU>

#include "krylov/grid.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

/// I − γ Δ on a grid.
Sparse even(Eigen::Index m, int dim, double gamma) {
  return grid(m, dim, gamma, [](Eigen::Index) { return 1; });
}
template <class P>
struct By {
  const Sparse& W;
  P p{};
  Vec none{};
  explicit By(const Sparse& matrix) : W{matrix} { p.compute(W); }
  void multiply(const Vec& x, Vec& out) const { out = W * x; }
  void precondition(const Vec& x, Vec& out) const { out = p.solve(x); }
  [[nodiscard]] const Vec& weights() const { return none; }
};
template <class P>
int iterations(const Sparse& W) {
  By<P> by{W};
  REQUIRE(by.p.info() == Eigen::Success);
  KrylovIteration<double, KrylovMethod::conjugate_gradients> cg;
  cg.resize(W.rows());
  Vec r = Vec::LinSpaced(W.rows(), 0, 40).array().sin(), x = Vec::Zero(W.rows());
  const Vec b = r;
  const KrylovEnd end = cg.solve(by, {0, 1e-8}, r, x);
  REQUIRE(end.converged);
  CHECK((W * x - b).norm() <= 1e-6 * b.norm());
  return end.iterations;
}

}  // namespace

TEST_CASE("where nothing is dropped, the factors are exact") {
  Sparse W = even(30, 2, 1e-3);
  Mat tridiagonal = Mat(W).topLeftCorner(30, 30);  // one line of the grid
  Mat arrow = 9 * Mat::Identity(8, 8);
  arrow.row(7).setConstant(-1), arrow.col(7).setConstant(-1), arrow(7, 7) = 9;
  const Mat full = Mat::Constant(5, 5, -0.5) + 4 * Mat::Identity(5, 5);
  for (const Mat& A : {tridiagonal, arrow, full}) {
    ModifiedIncompleteCholesky<> p;
    p.compute(A.sparseView());
    REQUIRE(p.info() == Eigen::Success);
    const Vec x = Vec::LinSpaced(A.rows(), -1, 2);
    CHECK((p.solve(A * x) - x).norm() <= 1e-14 * x.norm() * A.norm());
  }
}

TEST_CASE("with dropped fill, rows keep their sums but for two hundredths of what was dropped") {
  const Sparse W = even(12, 2, 1.0);
  ModifiedIncompleteCholesky<> p;
  p.compute(W);
  Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::NaturalOrdering<int>> plain(W);
  const Vec ones = Vec::Ones(W.rows()), sums = W * ones;
  CHECK((p.solve(sums) - ones).norm() < 0.3 * (plain.solve(sums) - ones).norm());
}

TEST_CASE("conjugate gradients need fewer iterations, and the more so the larger the grid") {
  using Modified = ModifiedIncompleteCholesky<>;
  using Plain = Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::NaturalOrdering<int>>;
  using Diagonal = Eigen::DiagonalPreconditioner<double>;
  const Sparse coarse = even(32, 2, 0.1), fine = even(128, 2, 0.1), cube = even(16, 3, 0.1);
  const int a = iterations<Modified>(coarse), b = iterations<Modified>(fine);
  CAPTURE(a, b, iterations<Plain>(coarse), iterations<Plain>(fine), iterations<Diagonal>(fine));
  CHECK(b <= 2.6 * a);  // four times the side: twice as many; plain ones four times
  CHECK(iterations<Plain>(fine) >= 3 * iterations<Plain>(coarse));
  CHECK(2 * b <= iterations<Plain>(fine));
  CHECK(6 * b <= iterations<Diagonal>(fine));
  CHECK(iterations<Modified>(cube) <= iterations<Plain>(cube));
}

TEST_CASE("a matrix with a diagonal that isn't positive is refused, another indefinite one survives") {
  ModifiedIncompleteCholesky<> p;
  Mat A = 2 * Mat::Identity(4, 4);
  A(2, 2) = -1;
  p.compute(A.sparseView());
  CHECK(p.info() == Eigen::NumericalIssue);
  A(2, 2) = 1, A(0, 1) = A(1, 0) = 5;
  p.compute(A.sparseView());
  CHECK(p.info() == Eigen::Success);
  CHECK(p.solve(Vec::Ones(4)).allFinite());
}
