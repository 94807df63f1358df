// Steps with a chain of blocks: right where block elimination is, and where only pivoting is.
#include "matrix/block_tridiagonal_system_cases.hpp"
#include "support/shared_force.hpp"

using namespace block_tridiagonal_cases;
using Rate = shared_force::OfState<Vec>;

namespace {

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
  const Statistics s = steps(y, that_makes(W), phi(1.0), 1, 1.0);
  CHECK((W * y - b).norm() <= 1e-13 * (W.norm() * y.norm() + b.norm()));
  CHECK(s.fallbacks == fallbacks);
  CHECK(s.factorizations == 1);
}

}  // namespace

TEST_CASE("blocks of two and three, by differences, equal the dense steps; a last block may be short") {
  const auto check = [](const Vec& dense, const Statistics& all, const Vec& chain, const Statistics& few, int colors) {
    CHECK(few.force_calls == few.iterations + colors * few.jacobians);
    CHECK(few.iterations == all.iterations);
    CHECK(few.fallbacks == 0);
    CHECK(few.analyses == 0);
    // To rounding in five steps: κ(W) ≤ 5, states of size 3.
    CHECK((dense - chain).cwiseAbs().maxCoeff() <= 5 * 5 * 3 * 8 * 2.3e-16);
  };
  const Rate by_two = brusselator, by_three = wide;
  Vec dense = start(40), chain = dense;
  const Statistics all = steps(dense, by_two, phi(0.5), 5, 0.05);
  const Statistics few = steps(chain, block_tridiagonal<2>(by_two), phi(0.5), 5, 0.05);
  check(dense, all, chain, few, 6);
  for (const Eigen::Index n : {3, 31, 32}) {
    dense = chain = wave(n);
    const Statistics every = steps(dense, by_three, phi(0.5), 5, 0.05);
    const Statistics some = steps(chain, block_tridiagonal<3>(by_three), phi(0.5), 5, 0.05);
    check(dense, every, chain, some, n == 3 ? 3 : 9);
  }
}

TEST_CASE("twenty thousand blocks") {
  Vec y = start(20000);
  const Statistics s = steps(y, block_tridiagonal<2>(Rate{brusselator}), phi(1.0), 2, 0.05);
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
  PhiStepper stepper{y, that_makes(W), phi(1.0)};
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
  PhiStepper stepper{y, that_makes(W), phi(1.0)};
  CHECK(stepper.step(y, 0, 1.0).outcome() == Outcome::singular_matrix);
  CHECK(y == before);
}
