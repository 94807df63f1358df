// Blocks on the diagonal: exact where there is nothing else, and what they spare where species react fast at each point.
#include <phistep/krylov.hpp>
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

/// a ⇌ b at each of n points, at different rates, and a and b diffuse: u = (a₀, b₀, a₁, b₁, …).
struct Reacting : ForceTerm {
  static constexpr Structure structure = Structure::sparse;
  Eigen::Index n = 40;
  double spread = 20;
  void entries(auto&& put) const {
    for (Eigen::Index k = 0; k < n; ++k) {
      const Eigen::Index a = 2 * k, b = a + 1;
      const double by = static_cast<double>(1 + 5 * k % 7), forth = by * 3e5, back = 1e5 / by;
      put(a, a, -forth - 2 * spread), put(a, b, back);
      put(b, a, forth), put(b, b, -back - 2 * spread);
      for (const Eigen::Index there : {k - 1, k + 1})
        if (there >= 0 && there < n) put(a, 2 * there, spread), put(b, 2 * there + 1, spread);
    }
  }
  void add(double, const auto& state, auto& out) const {
    entries([&](Eigen::Index i, Eigen::Index j, double x) { out.rate[i] += x * state.y[j]; });
  }
  void add_jacobian(double, const auto&, auto& sink) const {
    entries([&](Eigen::Index i, Eigen::Index j, double x) { sink.rate(i, j, x); });
  }
};
template <class P>
std::int64_t iterations(Vec& y) {
  y = Vec::LinSpaced(2 * Reacting{}.n, 0, 1);
  PhiStepper stepper{y, Reacting{}, backward_euler, newton<PreconditionedGmres<P>>()};
  for (int k = 0; k < 5; ++k) REQUIRE(stepper.step(y, 0, 1e-3));
  return stepper.statistics().linear_iterations;
}

}  // namespace

TEST_CASE("where W is nothing but blocks, they are its inverse, a last smaller one included") {
  for (const Eigen::Index n : {9, 8, 7, 1}) {
    Mat W = 5 * Mat::Identity(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        if (i / 3 == j / 3 && i != j) W(i, j) = static_cast<double>(i - 2 * j) / 9;
    BlockDiagonal<3> p;
    p.compute(W.sparseView());
    REQUIRE(p.info() == Eigen::Success);
    const Vec x = Vec::LinSpaced(n, -1, 2);
    CHECK((p.solve(W * x) - x).norm() <= 1e-14 * W.norm());
  }
}

TEST_CASE("a block that can't be inverted is an issue, and the next W is another one") {
  BlockDiagonal<2> p;
  Mat W = Mat::Identity(6, 6);
  W.block(2, 2, 2, 2).setOnes();
  p.compute(W.sparseView());
  CHECK(p.info() == Eigen::NumericalIssue);
  p.factorize(Mat(2 * Mat::Identity(6, 6)).sparseView());
  CHECK(p.info() == Eigen::Success);
  CHECK((p.solve(Vec::Ones(6)) - Vec::Constant(6, 0.5)).norm() == 0);
}

TEST_CASE("fast reactions at each point: half of the diagonal's iterations, and the same answer as LU") {
  Vec by_blocks, by_diagonal, by_lu = Vec::LinSpaced(2 * Reacting{}.n, 0, 1);
  const auto blocks = iterations<BlockDiagonal<2>>(by_blocks);
  const auto diagonal = iterations<Eigen::DiagonalPreconditioner<double>>(by_diagonal);
  PhiStepper stepper{by_lu, Reacting{}, backward_euler};
  for (int k = 0; k < 5; ++k) REQUIRE(stepper.step(by_lu, 0, 1e-3));
  CAPTURE(blocks, diagonal);
  CHECK(2 * blocks <= diagonal);
  CHECK((by_blocks - by_lu).norm() <= 1e-9 * by_lu.norm());
  CHECK((by_diagonal - by_lu).norm() <= 1e-9 * by_lu.norm());
}
