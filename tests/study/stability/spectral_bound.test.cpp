// Bounds of eigenvalues: never below the eigenvalue, and where theory says so equal to it.
#include <phistep/study/stability/spectral_bound.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>
#include <vector>

#include "instances/preflight.hpp"
#include "support/catch.hpp"
#if PHISTEP_STRESS
#include <phistep/study/stability/spectrum.hpp>
#endif

namespace spectral_bound_cases {

using namespace phistep;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Stiffness of unit springs between neighbours of a periodic triangular lattice of side × side particles.
inline SparseRows triangular_lattice(int side) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      for (int k = 0; k < 3; ++k) {
        const double angle = k * std::acos(-1.0) / 3;
        const int dx[] = {1, 0, -1}, dy[] = {0, 1, 1};
        const int i = y * side + x, j = (y + dy[k]) % side * side + (x + dx[k] + side) % side;
        const double n[] = {std::cos(angle), std::sin(angle)};
        for (int a = 0; a < 2; ++a)
          for (int b = 0; b < 2; ++b) {
            entries.emplace_back(2 * i + a, 2 * i + b, n[a] * n[b]);
            entries.emplace_back(2 * j + a, 2 * j + b, n[a] * n[b]);
            entries.emplace_back(2 * i + a, 2 * j + b, -n[a] * n[b]);
            entries.emplace_back(2 * j + a, 2 * i + b, -n[a] * n[b]);
          }
      }
  SparseRows A(2 * side * side, 2 * side * side);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

}  // namespace spectral_bound_cases

using namespace spectral_bound_cases;

#if PHISTEP_FULL

namespace {

/// λ_max of A u = λ diag(m) u by power iteration on A + shift, whose Rayleigh quotients come from below: an eigenvalue
/// solver would be most of what this file takes to compile.
double true_largest(const MatrixXd& A, const VectorXd& m) {
  const auto n = static_cast<std::size_t>(m.size());
  std::vector<double> S(n * n), x(n), y(n);
  double shift = 0;
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < n; ++j) {
      const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      sum += std::abs(S[i * n + j] = A(a, b) / std::sqrt(m[a] * m[b]));
    }
    shift = std::max(shift, sum);
    x[i] = 1 + 0.5 * std::sin(static_cast<double>(3 * i + 1));
  }
  double quotient = 0;
  for (int k = 0; k < 2000; ++k) {
    double xx = 0, xy = 0, yy = 0;
    for (std::size_t i = 0; i < n; ++i) {
      y[i] = shift * x[i];
      for (std::size_t j = 0; j < n; ++j) y[i] += S[i * n + j] * x[j];
      xx += x[i] * x[i], xy += x[i] * y[i], yy += y[i] * y[i];
    }
    quotient = xy / xx - shift;
    for (std::size_t i = 0; i < n; ++i) x[i] = y[i] / std::sqrt(yy);
  }
  return quotient;
}

}  // namespace

TEST_CASE("no bound lies below the eigenvalue: 1000 random matrices") {
  // A few here, and of the bounds of any matrix those that are similar to a symmetric one: D S D⁻¹.
  for (unsigned seed = 0; seed < 60; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> entry;
    std::uniform_real_distribution<double> exponent(-2, 2), there;
    const int d = static_cast<int>(seed % 3) + 1;
    const Eigen::Index n = d * static_cast<Eigen::Index>(2 + random() % 10);
    const double density = 0.1 + 0.9 * static_cast<double>(random() % 100) / 100;
    VectorXd m(n), scale(n);
    for (Eigen::Index i = 0; i < n; ++i) m[i] = i % d == 0 ? std::pow(10, exponent(random)) : m[i - 1];
    for (double& x : scale) x = std::pow(10, exponent(random) / 4);
    std::vector<Eigen::Triplet<double>> entries, negative, similar;
    MatrixXd S = MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j <= i; ++j) {
        if (there(random) >= density && j + 1 != i) continue;
        S(i, j) = S(j, i) = entry(random) * std::exp(entry(random));
      }
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        entries.emplace_back(i, j, S(i, j)), negative.emplace_back(i, j, -S(i, j));
        similar.emplace_back(i, j, scale[i] * S(i, j) / scale[j]);
      }
    SparseRows A(n, n), minus(n, n), B(n, n);
    A.setFromTriplets(entries.begin(), entries.end());
    minus.setFromTriplets(negative.begin(), negative.end());
    B.setFromTriplets(similar.begin(), similar.end());
    // The eigenvalues themselves carry rounding.
    const double rounding = 1e-12 * S.cwiseAbs().sum() / m.minCoeff();
    CHECK(largest_eigenvalue_bound(A, m, d).value >= true_largest(S, m) - rounding);
    CHECK(largest_eigenvalue_bound(minus, m, d).value >= true_largest(-S, m) - rounding);
    if (d == 2) CHECK(largest_eigenvalue_bound_by_blocks<2>(A, m).value >= true_largest(S, m) - rounding);
    if (d == 3) CHECK(largest_eigenvalue_bound_by_blocks<3>(A, m).value >= true_largest(S, m) - rounding);
    const VectorXd one = VectorXd::Ones(n);
    const double radius = std::max(true_largest(S, one), true_largest(-S, one));
    CHECK(spectral_radius_bound(B).value >= radius * (1 - 1e-8));
  }
}

TEST_CASE("the triangular lattice: blocks are exact, entries are not") {
  // ω² = 6 k/m at the middle of the zone's edge, which an even side holds.
  const SparseRows A = triangular_lattice(6);
  const VectorXd m = VectorXd::Ones(A.rows());
  CHECK(true_largest(MatrixXd(A), m) == Approx(6).epsilon(1e-12));
  CHECK(largest_eigenvalue_bound(A, m, 2).value == Approx(6).epsilon(1e-12));
  CHECK(largest_eigenvalue_bound_by_blocks<1>(A, m).value == Approx(5 + std::sqrt(3) + 1).epsilon(1e-2));
  CHECK(spectral_radius_bound(A).value == Approx(5 + std::sqrt(3) + 1).epsilon(1e-2));
}

TEST_CASE("weights find a light particle among heavy ones, and which it is") {
  // A chain with springs 1, masses 1e6, one of mass 1: ω² of the light one between held neighbours is 2, and a little more.
  const int n = 300;
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i + 1 < n; ++i)
    for (const auto& [a, b, x] : {std::tuple{i, i, 1.}, {i + 1, i + 1, 1.}, {i, i + 1, -1.}, {i + 1, i, -1.}})
      entries.emplace_back(a, b, x);
  SparseRows A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  VectorXd m = VectorXd::Constant(n, 1e6);
  m[117] = 1;
  const EigenvalueBound bound = largest_eigenvalue_bound(A, m, 0);
  CHECK(bound.value >= true_largest(MatrixXd(A), m));
  CHECK(bound.value == Approx(2).epsilon(0.01));
  CHECK(bound.row == 117);
}

TEST_CASE("the modulus of a block") {
  Eigen::Matrix3d B;
  B << 1, 2, 3, -4, 5, 0.5, 0, -1, 2;
  const Eigen::Matrix3d P = modulus<3>(B);
  CHECK((P * P - B * B.transpose()).norm() < 1e-12 * B.squaredNorm());
  const Eigen::Matrix3d S = B + B.transpose();
  CHECK((modulus<3>(S) * modulus<3>(S) - S * S).norm() < 1e-12 * S.squaredNorm());
  CHECK((P - P.transpose()).norm() < 1e-13);
}

#elif PHISTEP_STRESS
// spectral_bound against 1000 random matrices.

namespace {

MatrixXd random_matrix(std::mt19937& random, Eigen::Index n, double density) {
  std::normal_distribution<double> entry;
  std::uniform_real_distribution<double> there;
  MatrixXd A = MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      // A cycle in all of them: the eigenvalues of nilpotent matrices would be rounding and nothing else.
      if (there(random) < density || j == (i + 1) % n) A(i, j) = entry(random) * std::exp(entry(random));
  return A;
}

double true_largest(const MatrixXd& A, const VectorXd& m) {
  const VectorXd s = m.cwiseSqrt().cwiseInverse();
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(s.asDiagonal() * A * s.asDiagonal()).eigenvalues().maxCoeff();
}

}  // namespace

TEST_CASE("no bound lies below the eigenvalue: 1000 random matrices") {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    const int d = static_cast<int>(seed % 3) + 1;
    const Eigen::Index n = d * static_cast<Eigen::Index>(2 + random() % 10);
    const MatrixXd A = random_matrix(random, n, 0.1 + 0.9 * static_cast<double>(random() % 100) / 100);
    VectorXd m(n);
    std::uniform_real_distribution<double> exponent(-2, 2);
    for (Eigen::Index i = 0; i < n; ++i) m[i] = i % d == 0 ? std::pow(10, exponent(random)) : m[i - 1];
    const MatrixXd S = A + A.transpose();
    // The eigenvalues themselves carry rounding.
    const double rounding = 1e-12 * S.cwiseAbs().sum() / m.minCoeff();
    CHECK(largest_eigenvalue_bound(SparseRows(S.sparseView()), m, d).value >= true_largest(S, m) - rounding);
    CHECK(largest_eigenvalue_bound(SparseRows((-S).sparseView()), m, d).value >= true_largest(-S, m) - rounding);
    if (d == 2)
      CHECK(largest_eigenvalue_bound_by_blocks<2>(SparseRows(S.sparseView()), m).value >=
            true_largest(S, m) - rounding);
    if (d == 3)
      CHECK(largest_eigenvalue_bound_by_blocks<3>(SparseRows(S.sparseView()), m).value >=
            true_largest(S, m) - rounding);
    double radius = 0;
    for (const auto lambda : eigenvalues_of(A)) radius = std::max(radius, std::abs(lambda));
    CHECK(spectral_radius_bound(SparseRows(A.sparseView())).value >= radius * (1 - 1e-8));
  }
}

#endif
