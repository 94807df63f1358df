// Steps with a chain of blocks: right where block elimination is, and where only pivoting is.
#include <phistep/phistep.hpp>

#include <cmath>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;

namespace {

Vec wave(Eigen::Index n) { return Vec::LinSpaced(n, 0, 7).array().sin(); }

/// The Brusselator on a line, (u, w) point by point: u_t = 1 + u²w − 4u + D Δu, w_t = 3u − u²w + D Δw.
Vec brusselator(const Vec& y) {
  Vec rate(y.size());
  const Eigen::Index points = y.size() / 2;
  for (Eigen::Index i = 0; i < points; ++i) {
    const double u = y[2 * i], w = y[2 * i + 1];
    const auto laplacian = [&](Eigen::Index c, double boundary) {
      const double left = i > 0 ? y[2 * i - 2 + c] : boundary, right = i + 1 < points ? y[2 * i + 2 + c] : boundary;
      return 20 * (left - 2 * y[2 * i + c] + right);
    };
    rate[2 * i] = 1 + u * u * w - 4 * u + laplacian(0, 1);
    rate[2 * i + 1] = 3 * u - u * u * w + laplacian(1, 3);
  }
  return rate;
}
Vec start(Eigen::Index points) {
  Vec y(2 * points);
  for (Eigen::Index i = 0; i < points; ++i)
    y[2 * i] = 1 + 0.5 * std::sin(0.1 * static_cast<double>(i)), y[2 * i + 1] = 3;
  return y;
}
/// A component that sees 4 to either side, each with a weight of its own: three components a block.
Vec wide(const Vec& y) {
  const Eigen::Index n = y.size();
  Vec rate(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    rate[i] = -9 * y[i] - y[i] * y[i] * y[i];
    for (Eigen::Index j = std::max<Eigen::Index>(0, (i / 3 - 1) * 3); j < std::min(n, (i / 3 + 2) * 3); ++j)
      rate[i] += std::cos(static_cast<double>(3 * i + 5 * j)) * y[j];
  }
  return rate;
}

template <class State>
Statistics steps(State& y, auto force, auto scheme, int count, double dt, const auto&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < count; ++k) {
    const StepReport report = stepper.step(y, dt * k, dt);
    INFO(report.message());
    REQUIRE(report);
  }
  return stepper.statistics();
}

/// y' = A y, entries handed over one by one.
struct Linear {
  static constexpr Structure structure = Structure::block_tridiagonal;
  static constexpr int block = 2;
  Mat A;
  void add(double, const auto& y, auto& out) const { out.rate += A * y.y; }
  void add_jacobian(double, const auto&, auto& sink) const {
    for (Eigen::Index j = 0; j < A.cols(); ++j)
      for (Eigen::Index i = 0; i < A.rows(); ++i)
        if (A(i, j) != 0) sink.rate(i, j, A(i, j));
  }
};
/// The A that makes W = 1 − Δt A for Δt = 1.
Linear that_makes(const Mat& W) { return {Mat::Identity(W.rows(), W.cols()) - W}; }

void check_solution(const Mat& W, int fallbacks) {
  Vec y = wave(W.rows());
  const Vec b = y;
  const Statistics s = steps(y, that_makes(W), backward_euler, 1, 1.0);
  CHECK((W * y - b).norm() <= 1e-13 * (W.norm() * y.norm() + b.norm()));
  CHECK(s.fallbacks == fallbacks);
  CHECK(s.factorizations == 1);
}

}  // namespace

TEST_CASE("blocks of two and three, by differences, equal the dense steps; a last block may be short") {
  const auto check = [](const Vec& from, auto force, auto annotated, int colors) {
    Vec dense = from, chain = from;
    const Statistics all = steps(dense, force, trapezoidal, 5, 0.05);
    const Statistics few = steps(chain, annotated, trapezoidal, 5, 0.05);
    CHECK(few.force_calls == few.iterations + colors * few.jacobians);
    CHECK(few.iterations == all.iterations);
    CHECK(few.fallbacks == 0);
    CHECK(few.analyses == 0);
    // To rounding in five steps: κ(W) ≤ 5, states of size 3.
    CHECK((dense - chain).cwiseAbs().maxCoeff() <= 5 * 5 * 3 * 8 * 2.3e-16);
  };
  check(start(40), brusselator, block_tridiagonal<2>(brusselator), 6);
  for (const Eigen::Index n : {3, 30, 31, 32}) check(wave(n), wide, block_tridiagonal<3>(wide), n == 3 ? 3 : 9);
}

TEST_CASE("a motion: K and C in blocks") {
  const auto force = [](const Vec& r, const Vec& v) -> Vec { return wide(r) + 0.2 * wide(v); };
  const Motion<Vec> from{wave(31), wave(31).reverse()};
  Motion<Vec> dense = from, chain = from;
  steps(dense, force, trapezoidal, 5, 0.05, mass(2.0));
  const Statistics s = steps(chain, block_tridiagonal<3>(force), trapezoidal, 5, 0.05, mass(2.0));
  CHECK(s.fallbacks == 0);
  CHECK((dense.r - chain.r).cwiseAbs().maxCoeff() <= 5 * 5 * 8 * 2.3e-16);
  CHECK((dense.v - chain.v).cwiseAbs().maxCoeff() <= 5 * 5 * 8 * 2.3e-16);
}

TEST_CASE("twenty thousand blocks") {
  Vec y = start(20000);
  const Statistics s = steps(y, block_tridiagonal<2>(brusselator), backward_euler, 2, 0.05);
  CHECK(s.fallbacks == 0);
  CHECK(y.allFinite());
}

TEST_CASE("a diagonal block that is singular or nearly so: a banded LU serves, and is counted") {
  constexpr int n = 8;
  Mat W = Mat::Zero(n, n);
  W.diagonal(2).setConstant(1), W.diagonal(-2).setConstant(1);
  for (const double tiny : {0.0, 1e-13, 1e-9}) {
    W.diagonal().setConstant(tiny);
    CAPTURE(tiny);
    check_solution(W, 1);
  }
  W.diagonal().setConstant(4);
  check_solution(W, 0);
}

TEST_CASE("growth without a singular block is noticed too") {
  // Elimination turns the second diagonal block into 1 − 1/(1 + δ): nearly nothing.
  constexpr int n = 6;
  Mat W = Mat::Zero(n, n);
  W.diagonal().setConstant(1), W.diagonal(2).setConstant(1), W.diagonal(-2).setConstant(1);
  W(0, 0) = W(1, 1) = 1 + 1e-12;
  check_solution(W, 1);
}

TEST_CASE("entries outside the blocks are not lost: a banded LU serves") {
  constexpr int n = 9;
  Mat W = 4 * Mat::Identity(n, n);
  W(0, 4) = 1;  // two blocks away
  check_solution(W, 1);
  W(8, 0) = 2;
  check_solution(W, 1);
  W(0, 4) = W(8, 0) = 0;
  W(4, 1) = 1;  // within the band of the blocks, but outside of them
  check_solution(W, 1);
}

TEST_CASE("after a fallback the blocks are tried again") {
  Mat W = Mat::Zero(4, 4);
  W.diagonal(2).setConstant(1), W.diagonal(-2).setConstant(1);
  Vec y = wave(4);
  PhiStepper stepper{y, that_makes(W), backward_euler};
  REQUIRE(stepper.step(y, 0, 1.0));
  CHECK(stepper.statistics().fallbacks == 1);
  REQUIRE(stepper.step(y, 0, 0.1));
  CHECK(stepper.statistics().fallbacks == 1);
  CHECK(stepper.statistics().factorizations == 2);
}

TEST_CASE("a singular chain is named, and the state keeps every bit") {
  Mat W = Mat::Identity(6, 6);
  W(3, 3) = 0;
  Vec y = wave(6);
  const Vec before = y;
  PhiStepper stepper{y, that_makes(W), backward_euler};
  CHECK(stepper.step(y, 0, 1.0).outcome() == Outcome::singular_matrix);
  CHECK(y == before);
}
