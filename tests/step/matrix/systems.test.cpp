// The contract of every linear system behind a resolve: W = M − γ_f C − γ_f γ_d K, its factors, its solve.
// Conjugate gradients, LLᵀ, and steps with a symmetric matrix: systems.stress.cpp, sparse/symmetric_sparse_system*.
#include "step/matrix/systems_cases.hpp"

using namespace systems_cases;

TEMPLATE_TEST_CASE("solves with W, again with new values, again with a new pattern", "", DenseFixed, DenseDynamic,
                   Diagonal, Banded, Lu, SymmetricSparse, SeekingSymmetry, Ldlt) {
  SystemOf<TestType> system;
  check_new_values_and_patterns(system);
}

TEMPLATE_TEST_CASE("an unchanged pattern is analysed once", "", Lu, SymmetricSparse, SeekingSymmetry, Ldlt) {
  SystemOf<TestType> system;
  check_one_analysis(system);
}

TEMPLATE_TEST_CASE("says that a matrix is singular", "", DenseFixed, DenseDynamic, Diagonal, Banded, Lu,
                   SymmetricSparse, SeekingSymmetry) {
  SystemOf<TestType> system;
  check_singular(system);
}

TEMPLATE_TEST_CASE("a solver for definite matrices refuses an indefinite one", "", Ldlt) {
  SystemOf<TestType> system;
  check_indefinite(system);
}

TEMPLATE_TEST_CASE("finds a tangent that is not finite", "", DenseFixed, DenseDynamic, Diagonal, Banded, Lu) {
  SystemOf<TestType> system;
  check_not_finite(system);
}

// The symmetric sparse system: LDLᵀ where W is definite, LU where it isn't, and a promise that is checked.
namespace {

/// Factorises W = 2 − γ C, which is to be the matrix given.
Outcome factorize(AnySystem& system, const Mat& W, Statistics& counts) {
  const Mat C = (2 * Mat::Identity(n, n) - W) / gamma_force;
  fill(system, Mat::Zero(n, n), C);
  return system.factorize(gamma_force, 0, counts);
}
void check_solution(AnySystem& system, const Mat& W) {
  const Vec b = Vec::LinSpaced(n, -1, 3);
  Vec x = b;
  REQUIRE(system.solve(x) == Outcome::success);
  CHECK((W * x - b).norm() <= 1e-13 * W.norm() * x.norm());
}
Mat band(double own, double beside) {
  Mat W = own * Mat::Identity(n, n);
  for (int i = 0; i + 1 < n; ++i) W(i, i + 1) = W(i + 1, i) = beside;
  return W;
}

}  // namespace

TEST_CASE("an indefinite linear system is solved exactly, whatever the sign of its pivots") {
  SystemOf<SymmetricSparse> system;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::srand(seed);
    Mat W = Mat::Identity(n, n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j <= i; ++j)
        if (const double x = 2.0 * std::rand() / RAND_MAX - 1; std::abs(x) >= 0.6) W(i, j) = W(j, i) = (i == j) - 6 * x;
    CAPTURE(seed);
    Statistics counts;
    REQUIRE(factorize(system, W, counts) == Outcome::success);
    CHECK(counts.fallbacks == 1);
    check_solution(system, W);
  }
}

TEST_CASE("a compressed net in a long step: indefinite matrices are solved by LU, and counted") {
  SystemOf<SymmetricSparse> system;
  Statistics counts;
  REQUIRE(factorize(system, band(1, 2), counts) == Outcome::success);
  check_solution(system, band(1, 2));
  CHECK(counts.fallbacks == 1);
  CHECK(counts.analyses == 2);  // one for each of the two solvers
  // Definite again: LDLᵀ serves.
  REQUIRE(factorize(system, band(5, 2), counts) == Outcome::success);
  check_solution(system, band(5, 2));
  CHECK(counts.fallbacks == 1);
  CHECK(counts.analyses == 2);
}

TEST_CASE("a zero on the diagonal is no reason to fail") {
  // LDLᵀ without pivoting has none, the matrix is as regular as can be.
  SystemOf<SymmetricSparse> system;
  Statistics counts;
  Mat W = Mat::Identity(n, n);
  W(0, 0) = W(1, 1) = 0, W(0, 1) = W(1, 0) = 1;
  REQUIRE(factorize(system, W, counts) == Outcome::success);
  CHECK(counts.fallbacks == 1);
  check_solution(system, W);
}

TEST_CASE("a tangent that isn't symmetric is named: one entry, a missing triangle, dashpots in motion") {
  SystemOf<SymmetricSparse> system;
  Statistics counts;
  const Mat W = band(4, -1);
  Mat off = W, alone = W, triangle = W;
  off(3, 2) += 1e-9;
  alone(0, 4) = 0.5;  // whose transpose has no entry
  for (int i = 0; i + 1 < n; ++i) triangle(i, i + 1) = 0;
  for (const Mat& bad : {off, alone, triangle}) {
    CHECK(factorize(system, bad, counts) == Outcome::not_symmetric);
    CHECK(factorize(system, W, counts) == Outcome::success);
  }
}

TEST_CASE("rounding doesn't break the promise") {
  SystemOf<SymmetricSparse> system;
  Statistics counts;
  Mat W = band(4, -1);
  for (int i = 0; i + 1 < n; ++i) W(i + 1, i) -= 4e-16;
  W(0, 4) = 1e-15;
  CHECK(factorize(system, W, counts) == Outcome::success);
  CHECK(counts.fallbacks == 0);
}

TEST_CASE("symmetry that nobody has promised is found, and LU serves from where it ends") {
  SystemOf<SeekingSymmetry> system;
  Statistics counts;
  const Mat W = band(5, 2);
  const auto solve_with = [&](const Mat& A, const char* name) {
    REQUIRE(factorize(system, A, counts) == Outcome::success);
    CHECK(std::string(system.system.name()) == name);
    check_solution(system, A);
  };
  CHECK(std::string(system.system.name()) == "sparse LDLT or LU");
  solve_with(W, "sparse LDLT, found symmetric");
  Mat rounded = W;
  rounded(3, 4) += 8e-16;
  solve_with(rounded, "sparse LDLT, found symmetric");
  CHECK(counts.fallbacks == 0);
  CHECK(counts.analyses == 1);
  Mat A = W;
  SECTION("where an entry differs by more than rounding") { A(3, 4) += 1e-13; }
  SECTION("where W is indefinite") { A = band(1, 2); }
  SECTION("where an entry has no transpose") { A(0, 4) = 0.5; }
  SECTION("where a transpose has no entry, in the last column") { A(0, n - 1) = 1e-3; }
  SECTION("where the two patterns have as many entries in each column") { A(0, 4) = A(4, 7) = A(7, 0) = 1e-3; }
  solve_with(A, "sparse LU");
  CHECK(counts.fallbacks == 1);
  CHECK(counts.analyses == 2);
  solve_with(W, "sparse LU");
  system.system.begin_anew();
  solve_with(W, "sparse LDLT, found symmetric");
  CHECK(counts.fallbacks == 1);
  CHECK(counts.factorizations == 5);
}
