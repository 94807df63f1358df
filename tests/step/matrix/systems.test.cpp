// The contract of every linear system behind a resolve: W = M − γ_f C − γ_f γ_d K, its factors, its solve. Conjugate
// gradients, LLᵀ, and steps with a symmetric matrix: the stress tier, sparse/symmetric_sparse_system*.
#include <phistep/linear/banded/banded_system.hpp>
#include <phistep/linear/sparse/sparse_system.hpp>
#include <phistep/step/matrix/dense_system.hpp>

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <type_traits>

#include "support/catch.hpp"
#if PHISTEP_STRESS
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseLU>
#endif

namespace systems_cases {

using namespace phistep;
using Mat = Eigen::MatrixXd;
using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

inline constexpr int n = 12;
inline constexpr double gamma_force = 0.3, gamma_drift = 0.2;

using DenseFixed = DenseSystem<double, n, true, true>;
using DenseDynamic = DenseSystem<double, Eigen::Dynamic, true, true>;
using Diagonal = DiagonalSystem<double, n, true, true>;
using Banded = BandedSystem<double, true, true>;
using Lu = SparseSystem<double, SparseLu<double>>;
using Ldlt = SparseSystem<double, Eigen::SimplicialLDLT<Sparse>>;
using SymmetricSparse = SymmetricSparseSystem<double, Symmetry::promised, false>;
using SeekingSymmetry = SymmetricSparseSystem<double, Symmetry::sought, false>;

template <class System>
inline constexpr bool is_diagonal = std::is_same_v<System, Diagonal>;
/// Sparse solvers but LU are for symmetric matrices.
template <class System>
inline constexpr bool is_symmetric = false;
template <>
inline constexpr bool is_symmetric<SymmetricSparse> = true;
template <class Solver>
inline constexpr bool is_symmetric<SparseSystem<double, Solver>> = true;
template <>
inline constexpr bool is_symmetric<Lu> = false;

/// Masses 2 on the diagonal.
inline const auto masses = [](auto&& put) {
  for (int i = 0; i < n; ++i) put(i, i, 2.0);
};

/// A system of any type, so that what is checked is compiled once.
struct AnySystem {
  virtual ~AnySystem() = default;
  virtual void clear() = 0;
  virtual void position(int i, int j, double x) = 0;
  virtual void velocity(int i, int j, double x) = 0;
  [[nodiscard]] virtual bool is_finite() = 0;
  virtual Outcome factorize(double force, double drift, Statistics& counts) = 0;
  virtual Outcome solve(Vec& b) = 0;
  bool is_diagonal = false, is_symmetric = false;
};
template <class System>
struct SystemOf final : AnySystem {
  System system;
  SystemOf() {
    system.resize(n);
    is_diagonal = systems_cases::is_diagonal<System>, is_symmetric = systems_cases::is_symmetric<System>;
  }
  void clear() override { system.clear(); }
  void position(int i, int j, double x) override { system.position(i, j, x); }
  void velocity(int i, int j, double x) override { system.velocity(i, j, x); }
  bool is_finite() override { return system.is_finite(); }
  Outcome factorize(double force, double drift, Statistics& counts) override {
    return system.factorize(masses, force, drift, counts);
  }
  Outcome solve(Vec& b) override {
    if constexpr (std::is_same_v<System, DenseFixed> || systems_cases::is_diagonal<System>) {
      Eigen::Matrix<double, n, 1> fixed = b;
      const Outcome outcome = system.solve(fixed);
      b = fixed;
      return outcome;
    } else {
      return system.solve(b);
    }
  }
};

/// A chain's tangents, scaled; diagonal where the system can't hold more.
inline Mat chain(const AnySystem& system, double scale) {
  Mat A = -2 * Mat::Identity(n, n);
  if (!system.is_diagonal)
    for (int i = 0; i + 1 < n; ++i) A(i, i + 1) = A(i + 1, i) = 0.9;
  if (!system.is_diagonal && !system.is_symmetric) A(3, 4) = -2.5;
  return scale * A;
}

/// Hands K and C to the sink, K's entries in two halves, as forces with several terms do.
inline void fill(AnySystem& system, const Mat& K, const Mat& C) {
  system.clear();
  for (int half = 0; half < 2; ++half)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        if (K(i, j) != 0) system.position(i, j, K(i, j) / 2);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      if (C(i, j) != 0) system.velocity(i, j, C(i, j));
}

inline void check_solves(AnySystem& system, const Mat& K, const Mat& C, Statistics& counts) {
  fill(system, K, C);
  REQUIRE(system.is_finite());
  REQUIRE(system.factorize(gamma_force, gamma_drift, counts) == Outcome::success);
  const Mat W = 2 * Mat::Identity(n, n) - gamma_force * (C + gamma_drift * K);
  const Vec b = Vec::LinSpaced(n, -1, 3);
  Vec x = b;
  REQUIRE(system.solve(x) == Outcome::success);
  CHECK((W * x - b).norm() <= 1e-13 * b.norm() * W.norm());
}

inline void check_new_values_and_patterns(AnySystem& system) {
  Statistics counts;
  const Mat A = chain(system, 1), none = Mat::Zero(n, n);
  check_solves(system, 40 * A, 3 * A, counts);
  check_solves(system, 80 * A, 2 * A, counts);
  if (!system.is_diagonal) {
    Mat wider = A;
    wider(0, n - 1) = wider(n - 1, 0) = 0.1;
    check_solves(system, 40 * wider, 3 * A, counts);
    check_solves(system, 40 * A, none, counts);
  } else {
    check_solves(system, 40 * A, none, counts);
    check_solves(system, 40 * A, A, counts);
  }
  CHECK(counts.factorizations == 4);
}
inline void check_one_analysis(AnySystem& system) {
  Statistics counts;
  const Mat A = chain(system, 1);
  for (int k = 1; k <= 5; ++k) check_solves(system, k * A, A, counts);
  CHECK(counts.analyses == 1);
  CHECK(counts.factorizations == 5);
}
inline void check_singular(AnySystem& system) {
  Statistics counts;
  // W = 2 − γ_f C vanishes altogether, or in one row and column.
  const Mat none = Mat::Zero(n, n);
  fill(system, none, (2 / gamma_force) * Mat::Identity(n, n));
  CHECK(system.factorize(gamma_force, 0, counts) == Outcome::singular_matrix);
  Mat C = none;
  C(5, 5) = 2 / gamma_force;
  fill(system, none, C);
  CHECK(system.factorize(gamma_force, 0, counts) == Outcome::singular_matrix);
  check_solves(system, chain(system, 1), chain(system, 1), counts);  // and recovers
}
inline void check_indefinite(AnySystem& system) {
  Statistics counts;
  const Mat none = Mat::Zero(n, n);
  for (const int where : {0, 5, n - 1}) {
    Mat C = none;
    C(where, where) = 100;
    fill(system, none, C);
    CHECK(system.factorize(gamma_force, 0, counts) == Outcome::not_positive_definite);
  }
  fill(system, none, (2 / gamma_force) * Mat::Identity(n, n));  // semi-definite: W = 0
  CHECK(system.factorize(gamma_force, 0, counts) == Outcome::not_positive_definite);
  check_solves(system, chain(system, 1), chain(system, 1), counts);
}
inline void check_not_finite(AnySystem& system) {
  Statistics counts;
  const Mat A = chain(system, 1);
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

}  // namespace systems_cases

using namespace systems_cases;

#if PHISTEP_FULL

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
    CHECK(std::string(system.system.name("sparse LDLT or LU")) == name);
    check_solution(system, A);
  };
  CHECK(std::string(system.system.name("sparse LDLT or LU")) == "sparse LDLT or LU");
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

// W of random exchanges with rates of nine decades, each unknown's number 1e-9 to 1e9 times what it was. Errors in plain units.
TEST_CASE("dense W in units that differ: pivots by what entries are worth keep the digits, by numbers they lose them") {
  std::srand(46);
  double worst = 0, worst_by_numbers = 0;
  for (int k = 0; k < 200; ++k) {
    Mat C = Mat::Random(n, n).unaryExpr([](double u) { return std::pow(10.0, 4.5 * u); });
    C.diagonal().setZero();
    C.diagonal() = -C.colwise().sum().transpose();
    const Vec x = Vec::Ones(n), unit = Vec::Random(n).unaryExpr([](double u) { return std::pow(10.0, 9 * u); });
    for (const bool scales : {false, true}) {
      DenseDynamic W;
      W.resize(n);
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) W.velocity(i, j, C(i, j) * unit[i] / unit[j]);
      W.scale_rows_by([&](auto& weight) { weight = unit.cwiseInverse(); }, scales ? 1e-6 : 0);
      Statistics counts;
      REQUIRE(W.factorize(masses, gamma_force, gamma_drift, counts) == Outcome::success);
      const Mat plain = 2 * Mat::Identity(n, n) - gamma_force * C;
      Vec b = (plain * x).cwiseProduct(unit);
      REQUIRE(W.solve(b) == Outcome::success);
      const double error = (b.cwiseQuotient(unit) - x).norm();
      double& most = scales ? worst : worst_by_numbers;
      most = std::max(most, error);
    }
  }
  CHECK(worst < 1e-10);
  CHECK(worst_by_numbers > 1e-8);
}

// The first unknown is 0 and made by none; the others' rates would change much with it.
TEST_CASE("dense W: what nothing makes stays 0 to the last bit, in units alike and not") {
  std::srand(47);
  for (int k = 0; k < 100; ++k) {
    DenseDynamic W;
    W.resize(n);
    const double unit = std::pow(10.0, k % 10);
    for (int j = 0; j < n; ++j)
      for (int i = j == 0 ? 0 : 1; i < n; ++i) W.velocity(i, j, j == 0 ? 1e9 : unit * (i == j ? -2 : 1));
    W.scale_rows_by([&](auto& weight) { weight = Vec::Ones(n) - Vec::Unit(n, 0); }, 1e-4);
    Statistics counts;
    REQUIRE(W.factorize(masses, gamma_force, gamma_drift, counts) == Outcome::success);
    Vec b = Vec::Random(n);
    b[0] = 0;
    REQUIRE(W.solve(b) == Outcome::success);
    CHECK(b[0] == 0);
  }
}

#elif PHISTEP_STRESS
// The linear systems whose solvers are dear to compile.

namespace {

using Llt = SparseSystem<double, Eigen::SimplicialLLT<Sparse>>;
using Cg = SparseSystem<double, Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper>>;
using EigensLu = SparseSystem<double, Eigen::SparseLU<Sparse>>;

}  // namespace

TEMPLATE_TEST_CASE("solves with W, again with new values, again with a new pattern", "", Llt, Cg, EigensLu) {
  SystemOf<TestType> system;
  check_new_values_and_patterns(system);
}

TEMPLATE_TEST_CASE("a solver for definite matrices refuses an indefinite one", "", Llt) {
  SystemOf<TestType> system;
  check_indefinite(system);
}

TEST_CASE("conjugate gradients on an indefinite matrix either solve or say that they failed") {
  SystemOf<Cg> system;
  Statistics counts;
  const Mat C = Vec::LinSpaced(n, -30, 90).asDiagonal();
  fill(system, Mat::Zero(n, n), C);
  REQUIRE(system.factorize(gamma_force, 0, counts) == Outcome::success);
  const Vec b = Vec::Ones(n);
  Vec x = b;
  const Mat W = 2 * Mat::Identity(n, n) - gamma_force * C;
  const Outcome outcome = system.solve(x);
  CHECK((outcome == Outcome::linear_solver_failed || (W * x - b).norm() <= 1e-10));
}

#endif
