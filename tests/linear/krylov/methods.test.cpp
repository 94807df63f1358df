// Krylov methods: solutions, where they stop, what they refuse.
#include <phistep/linear/krylov/methods.hpp>

#include <Eigen/LU>

#include <cstdlib>
#include <limits>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;

namespace {

constexpr int n = 60;

/// A dense W, P its diagonal.
struct Dense {
  Mat W;
  Vec w{};
  int products = 0;
  void multiply(const Vec& x, Vec& out) { ++products, out = W * x; }
  void precondition(const Vec& x, Vec& out) const { out = x.cwiseQuotient(W.diagonal()); }
  [[nodiscard]] const Vec& weights() const { return w; }
};
/// A chain's stiffness on a bed of springs, with wind.
Mat chain(double wind) {
  Mat W = 2.1 * Mat::Identity(n, n);
  W.diagonal(1).setConstant(-1 + wind), W.diagonal(-1).setConstant(-1 - wind);
  for (int i = 0; i < n; ++i) W(i, i) += i % 3;
  return W;
}
template <KrylovMethod method>
KrylovEnd solve(Dense& W, const KrylovGoal& goal, const Vec& b, Vec& x) {
  KrylovIteration<double, method> iteration;
  iteration.resize(b.size());
  Vec r = b;
  x.setZero(b.size());
  return iteration.solve(W, goal, r, x);
}
const Vec b = Vec::LinSpaced(n, -1, 3).array().sin();

}  // namespace

TEMPLATE_TEST_CASE_SIG("solves to the size of the preconditioned residual that is asked for", "",
                       ((KrylovMethod method), method), KrylovMethod::conjugate_gradients, KrylovMethod::bicgstab,
                       KrylovMethod::gmres) {
  for (const double wind : {0.0, 0.4}) {
    if (wind != 0 && method == KrylovMethod::conjugate_gradients) continue;
    Dense W{chain(wind)};
    const Vec exact = W.W.fullPivLu().solve(b);
    int last = 0;
    for (const double goal : {1e-2, 1e-5, 1e-10}) {
      Vec x;
      const KrylovEnd end = solve<method>(W, {goal, 0}, b, x);
      REQUIRE(end.converged);
      Vec z;
      W.precondition(b - W.W * x, z);
      CAPTURE(wind, goal, end.iterations);
      CHECK(z.norm() / std::sqrt(n) <= goal * (1 + 1e-3));
      CHECK((x - exact).norm() / std::sqrt(n) <= 50 * goal);  // ‖W⁻¹P‖
      CHECK(end.iterations > last);
      last = end.iterations;
    }
    Vec x;
    const Vec first = b.cwiseQuotient(W.W.diagonal());
    CHECK(solve<method>(W, {1.01 * first.norm() / std::sqrt(n), 0}, b, x).iterations == 0);
    CHECK(x.isZero(0));
    CHECK(solve<method>(W, {0.99 * first.norm() / std::sqrt(n), 0}, b, x).iterations >= 1);
    CHECK(solve<method>(W, {0, 1e-6}, Vec::Zero(n), x).iterations == 0);
  }
}

TEMPLATE_TEST_CASE_SIG("weights say which components count", "", ((KrylovMethod method), method),
                       KrylovMethod::conjugate_gradients, KrylovMethod::bicgstab, KrylovMethod::gmres) {
  // Two blocks that know nothing of each other: with no weight on the second, its size doesn't matter.
  Dense W{chain(0)};
  W.W.topRightCorner(n / 2, n / 2).setZero(), W.W.bottomLeftCorner(n / 2, n / 2).setZero();
  W.w = Vec::Ones(n);
  W.w.tail(n / 2).setConstant(1e-12);
  Vec right = b, x;
  right.tail(n / 2) *= 1e3;
  const Vec exact = W.W.fullPivLu().solve(right);
  REQUIRE(solve<method>(W, {1e-6, 0}, right, x).converged);
  CHECK((x - exact).head(n / 2).norm() <= 1e-4);
  Dense same{W.W};
  Vec y;
  REQUIRE(solve<method>(same, {1e-6, 0}, right, y).converged);
  CHECK((y - exact).norm() <= 1e-4);
  CHECK(W.products <= same.products);
}

TEST_CASE("products: one an iteration of conjugate gradients, two of BiCGSTAB, one of GMRES and one a restart") {
  Vec x;
  Dense cg{chain(0)}, stab{chain(0)}, gmres{chain(0)};
  CHECK(solve<KrylovMethod::conjugate_gradients>(cg, {1e-8, 0}, b, x).iterations == cg.products);
  CHECK(2 * solve<KrylovMethod::bicgstab>(stab, {1e-8, 0}, b, x).iterations == stab.products);
  const int taken = solve<KrylovMethod::gmres>(gmres, {1e-8, 0}, b, x).iterations;
  CHECK(gmres.products == taken + (taken - 1) / KrylovIteration<double, KrylovMethod::gmres>::restart);
}

TEST_CASE("an indefinite matrix is refused by conjugate gradients, and none converges without iterations") {
  Dense W{chain(0)};
  W.W.diagonal().array() -= 2.5;
  Vec x;
  CHECK_FALSE(solve<KrylovMethod::conjugate_gradients>(W, {1e-8, 0}, b, x).converged);
  Dense good{chain(0)};
  const KrylovGoal few{1e-12, 0, 3};
  CHECK_FALSE(solve<KrylovMethod::conjugate_gradients>(good, few, b, x).converged);
  CHECK_FALSE(solve<KrylovMethod::bicgstab>(good, few, b, x).converged);
  CHECK_FALSE(solve<KrylovMethod::gmres>(good, few, b, x).converged);
  const Vec bad = Vec::Constant(n, std::numeric_limits<double>::quiet_NaN());
  CHECK_FALSE(solve<KrylovMethod::conjugate_gradients>(good, {1e-8, 0}, bad, x).converged);
  CHECK_FALSE(solve<KrylovMethod::bicgstab>(good, {1e-8, 0}, bad, x).converged);
  CHECK_FALSE(solve<KrylovMethod::gmres>(good, {1e-8, 0}, bad, x).converged);
}
