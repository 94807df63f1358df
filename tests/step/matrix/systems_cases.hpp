#pragma once

// What systems.test.cpp and its full half share.

#include <phistep/linear/banded/banded_system.hpp>
#include <phistep/linear/sparse/sparse_system.hpp>
#include <phistep/linear/sparse/symmetric_sparse_system.hpp>
#include <phistep/step/matrix/dense_system.hpp>

#include <Eigen/SparseCholesky>

#include <cmath>
#include <cstdlib>
#include <type_traits>

#include "support/catch.hpp"

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
using Lu = SparseSystem<double, Eigen::SparseLU<Sparse>>;
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
inline constexpr bool is_symmetric<SparseSystem<double, Solver>> = !std::is_same_v<Solver, Eigen::SparseLU<Sparse>>;

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
