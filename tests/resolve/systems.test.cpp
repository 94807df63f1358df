// The contract of every linear system behind a resolve: W = M − γ_f C − γ_f γ_d K, its factors, its solve.
#include <phistep/resolve/banded_system.hpp>
#include <phistep/resolve/block_tridiagonal_system.hpp>
#include <phistep/resolve/dense_system.hpp>
#include <phistep/resolve/sparse_system.hpp>
#include <phistep/resolve/symmetric_sparse_system.hpp>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>

#include <cmath>

#include "support/catch.hpp"

using namespace phistep;
using Mat = Eigen::MatrixXd;
using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

constexpr int n = 12;
constexpr double gamma_force = 0.3, gamma_drift = 0.2;

using DenseFixed = DenseSystem<double, n, true, true>;
using DenseDynamic = DenseSystem<double, Eigen::Dynamic, true, true>;
using Diagonal = DiagonalSystem<double, n, true, true>;
using Banded = BandedSystem<double, true, true>;
using Blocks1 = BlockTridiagonalSystem<double, 1, true, true>;
using Blocks3 = BlockTridiagonalSystem<double, 3, true, true>;
using Blocks5 = BlockTridiagonalSystem<double, 5, true, true>;  // the last block isn't full
using Lu = SparseSystem<double, Eigen::SparseLU<Sparse>>;
using Ldlt = SparseSystem<double, Eigen::SimplicialLDLT<Sparse>>;
using SymmetricSparse = SymmetricSparseSystem<double, false>;
using Llt = SparseSystem<double, Eigen::SimplicialLLT<Sparse>>;
using Cg = SparseSystem<double, Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper>>;

template <class System>
inline constexpr bool is_diagonal = std::is_same_v<System, Diagonal>;
template <class System>
inline constexpr bool is_symmetric = std::is_same_v<System, SymmetricSparse> || std::is_same_v<System, Ldlt> ||
                                     std::is_same_v<System, Llt> || std::is_same_v<System, Cg>;

/// Masses 2 on the diagonal.
const auto masses = [](auto&& put) {
  for (int i = 0; i < n; ++i) put(i, i, 2.0);
};

/// A chain's tangents, scaled; diagonal where the system can't hold more.
template <class System>
Mat chain(double scale) {
  Mat A = -2 * Mat::Identity(n, n);
  if (!is_diagonal<System>)
    for (int i = 0; i + 1 < n; ++i) A(i, i + 1) = A(i + 1, i) = 0.9;
  if (!is_diagonal<System> && !is_symmetric<System>) A(3, 4) = -2.5;
  return scale * A;
}

/// Hands K and C to the sink, K's entries in two halves, as forces with several terms do.
void fill(auto& system, const Mat& K, const Mat& C) {
  system.clear();
  for (int half = 0; half < 2; ++half)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        if (K(i, j) != 0) system.position(i, j, K(i, j) / 2);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      if (C(i, j) != 0) system.velocity(i, j, C(i, j));
}

template <class System>
void check_solves(System& system, const Mat& K, const Mat& C, Statistics& counts) {
  fill(system, K, C);
  REQUIRE(system.is_finite());
  REQUIRE(system.factorize(masses, gamma_force, gamma_drift, counts) == Outcome::success);
  const Mat W = 2 * Mat::Identity(n, n) - gamma_force * (C + gamma_drift * K);
  const Vec b = Vec::LinSpaced(n, -1, 3);
  Eigen::Matrix<double, n, 1> fixed = b;
  Vec dynamic = b;
  if constexpr (std::is_same_v<System, DenseFixed> || is_diagonal<System>) {
    REQUIRE(system.solve(fixed) == Outcome::success);
    dynamic = fixed;
  } else {
    REQUIRE(system.solve(dynamic) == Outcome::success);
  }
  CHECK((W * dynamic - b).norm() <= 1e-13 * b.norm() * W.norm());
}

}  // namespace

TEMPLATE_TEST_CASE("solves with W, again with new values, again with a new pattern", "", DenseFixed, DenseDynamic,
                   Diagonal, Banded, Blocks1, Blocks3, Blocks5, Lu, SymmetricSparse, Ldlt, Llt, Cg) {
  TestType system;
  system.resize(n);
  Statistics counts;
  const Mat A = chain<TestType>(1);
  check_solves(system, 40 * A, 3 * A, counts);
  check_solves(system, 80 * A, 2 * A, counts);
  if constexpr (!is_diagonal<TestType>) {
    Mat wider = A;
    wider(0, n - 1) = wider(n - 1, 0) = 0.1;
    check_solves(system, 40 * wider, 3 * A, counts);
    check_solves(system, 40 * A, Mat::Zero(n, n), counts);
  } else {
    check_solves(system, 40 * A, Mat::Zero(n, n), counts);
    check_solves(system, 40 * A, A, counts);
  }
  CHECK(counts.factorizations == 4);
}

TEMPLATE_TEST_CASE("an unchanged pattern is analysed once", "", Lu, SymmetricSparse, Ldlt) {
  TestType system;
  system.resize(n);
  Statistics counts;
  const Mat A = chain<TestType>(1);
  for (int k = 1; k <= 5; ++k) check_solves(system, k * A, A, counts);
  CHECK(counts.analyses == 1);
  CHECK(counts.factorizations == 5);
}

TEMPLATE_TEST_CASE("says that a matrix is singular", "", DenseFixed, DenseDynamic, Diagonal, Banded, Blocks1, Blocks3,
                   Blocks5, Lu, SymmetricSparse) {
  TestType system;
  system.resize(n);
  Statistics counts;
  // W = 2 − γ_f C vanishes altogether, or in one row and column.
  fill(system, Mat::Zero(n, n), (2 / gamma_force) * Mat::Identity(n, n));
  CHECK(system.factorize(masses, gamma_force, 0, counts) == Outcome::singular_matrix);
  Mat C = Mat::Zero(n, n);
  C(5, 5) = 2 / gamma_force;
  fill(system, Mat::Zero(n, n), C);
  CHECK(system.factorize(masses, gamma_force, 0, counts) == Outcome::singular_matrix);
  check_solves(system, chain<TestType>(1), chain<TestType>(1), counts);  // and recovers
}

TEMPLATE_TEST_CASE("a solver for definite matrices refuses an indefinite one", "", Ldlt, Llt) {
  TestType system;
  system.resize(n);
  Statistics counts;
  for (const int where : {0, 5, n - 1}) {
    Mat C = Mat::Zero(n, n);
    C(where, where) = 100;
    fill(system, Mat::Zero(n, n), C);
    CHECK(system.factorize(masses, gamma_force, 0, counts) == Outcome::not_positive_definite);
  }
  fill(system, Mat::Zero(n, n), (2 / gamma_force) * Mat::Identity(n, n));  // semi-definite: W = 0
  CHECK(system.factorize(masses, gamma_force, 0, counts) == Outcome::not_positive_definite);
  check_solves(system, chain<TestType>(1), chain<TestType>(1), counts);
}

TEST_CASE("conjugate gradients on an indefinite matrix either solve or say that they failed") {
  Cg system;
  system.resize(n);
  Statistics counts;
  const Mat C = Vec::LinSpaced(n, -30, 90).asDiagonal();
  fill(system, Mat::Zero(n, n), C);
  REQUIRE(system.factorize(masses, gamma_force, 0, counts) == Outcome::success);
  const Vec b = Vec::Ones(n);
  Vec x = b;
  const Mat W = 2 * Mat::Identity(n, n) - gamma_force * C;
  const Outcome outcome = system.solve(x);
  CHECK((outcome == Outcome::linear_solver_failed || (W * x - b).norm() <= 1e-10));
}

TEMPLATE_TEST_CASE("finds a tangent that is not finite", "", DenseFixed, DenseDynamic, Diagonal, Banded, Blocks1,
                   Blocks3, Blocks5, Lu) {
  TestType system;
  system.resize(n);
  Statistics counts;
  const Mat A = chain<TestType>(1);
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    Mat K = A;
    K(n - 1, n - 1) = bad;
    fill(system, K, A);
    CHECK_FALSE(system.is_finite());
    fill(system, A, K);
    CHECK_FALSE(system.is_finite());
    // Two infinities of either sign in one slot must not hide.
    fill(system, A, A);
    system.velocity(2, 2, HUGE_VAL);
    system.velocity(2, 2, -HUGE_VAL);
    CHECK_FALSE(system.is_finite());
  }
  check_solves(system, A, A, counts);
}
