// Eisenstat's form of conjugate gradients: the same iterates as with the factors themselves, where their pattern allows it.
#include <phistep/krylov/eisenstat.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "krylov/grid.hpp"
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
struct ByFactors {
  const Sparse& W;
  Vec w;
  ModifiedIncompleteCholesky<> p{};
  void multiply(const Vec& x, Vec& out) const { out = W * x; }
  void precondition(const Vec& x, Vec& out) const { out = p.solve(x); }
  [[nodiscard]] const Vec& weights() const { return w; }
};
using Two = EisenstatCg<double>;

}  // namespace

TEST_CASE("conjugate gradients with the factors themselves take the same iterations to the same x") {
  for (const Sparse& W : {uneven(24, 2, 0.1), uneven(9, 3, 0.1), shuffled(uneven(24, 2, 0.1)), uneven(24, 2, 1e-6)}) {
    const Eigen::Index n = W.rows();
    const Vec b = Vec::LinSpaced(n, 0, 40).array().sin(), w = Vec::LinSpaced(n, 0.5, 3);
    ByFactors by{W, w};
    by.p.compute(W);
    KrylovIteration<double, KrylovMethod::conjugate_gradients> cg;
    cg.resize(n);
    Two two;
    REQUIRE(two.analyze(W));
    REQUIRE(two.factorize(W) == Two::Found::definite);
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
  REQUIRE(two.factorize(first) == Two::Found::definite);
  REQUIRE(two.factorize(W) == Two::Found::definite);
  const Vec exact = Vec::LinSpaced(W.rows(), -1, 2);
  Vec r = W * exact, x = Vec::Zero(W.rows());
  REQUIRE(two.solve({.relative = 1e-13}, r, x).converged);
  CHECK((x - exact).norm() <= 1e-11 * exact.norm());
}

TEST_CASE("patterns whose factors have other entries than W are not taken, nor values that aren't symmetric") {
  const auto takes = [](Sparse W) {
    W.makeCompressed();
    return Two{}.analyze(W);
  };
  CHECK(takes(uneven(5, 2, 1)));
  CHECK(takes(uneven(5, 3, 1)));
  Mat square = 4 * Mat::Identity(4, 4);  // a cycle of four has no triangle, with a diagonal it has two
  for (int i = 0; i < 4; ++i) square(i, (i + 1) % 4) = square((i + 1) % 4, i) = -1;
  CHECK(takes(square.sparseView()));
  square(0, 2) = square(2, 0) = -0.5;
  CHECK_FALSE(takes(square.sparseView()));
  Mat one_way = 4 * Mat::Identity(4, 4);
  one_way(0, 1) = -1;
  CHECK_FALSE(takes(one_way.sparseView()));
  Mat no_diagonal = Mat::Identity(3, 3);
  no_diagonal(1, 1) = 0;
  CHECK_FALSE(takes(no_diagonal.sparseView()));

  Two two;
  Sparse W = uneven(5, 2, 1);
  REQUIRE(two.analyze(W));
  W.coeffRef(7, 8) *= 1.01;
  CHECK(two.factorize(W) == Two::Found::unsymmetric);
  W = uneven(5, 2, 1);
  W.coeffRef(7, 7) = -1;
  CHECK(two.factorize(W) == Two::Found::indefinite);
  CHECK(two.factorize(uneven(5, 2, 1)) == Two::Found::definite);
}

TEST_CASE("an indefinite matrix with a positive diagonal is refused in the iteration") {
  Sparse W = uneven(8, 2, 1);
  for (Eigen::Index i = 0; i < W.rows(); ++i) W.coeffRef(i, i) -= 200;
  Two two;
  REQUIRE(two.analyze(W));
  REQUIRE(two.factorize(W) == Two::Found::definite);  // as far as the diagonal shows
  Vec r = Vec::LinSpaced(W.rows(), 1, 2), x = Vec::Zero(W.rows());
  CHECK_FALSE(two.solve({.relative = 1e-8}, r, x).converged);
}
