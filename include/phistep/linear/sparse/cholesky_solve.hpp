/// @file
/// x ← W⁻¹ x with Eigen's sparse LLᵀ or LDLᵀ, in place.
///
/// Eigen's own solve() allocates a result and a mask to permute it; with a workspace of the caller's, nothing is.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Eigen::SimplicialLLT, Eigen::SimplicialLDLT.
template <class Solver>
concept SimplicialFactors = requires(const Solver& solver) {
  solver.matrixL();
  solver.matrixU();
  solver.permutationP();
  solver.permutationPinv();
};

/// Solves Pᵀ L D Lᵀ P x = b (D = 1 for LLᵀ). read(solver) after each factorization, then solve_in_place(solver, x).
template <class Scalar>
class CholeskySolve {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  /// Eigen hands D out by value only: one copy a factorization instead of one a solve.
  template <SimplicialFactors Solver>
  void read(const Solver& solver) {
    if constexpr (requires { solver.vectorD(); }) pivots_ = solver.vectorD();
  }
  /// D, in the order of elimination; empty for LLᵀ.
  [[nodiscard]] const Vector& pivots() const { return pivots_; }

  template <SimplicialFactors Solver>
  void solve_in_place(const Solver& solver, auto& x) {
    work_.resize(x.size());
    const auto& place = solver.permutationP().indices();
    const bool permuted = place.size() > 0;  // not where the user chose the natural ordering
    for (Eigen::Index i = 0; i < x.size(); ++i) work_[permuted ? place[i] : i] = x[i];
    solver.matrixL().solveInPlace(work_);
    if constexpr (requires { solver.vectorD(); }) work_.array() /= pivots_.array();
    solver.matrixU().solveInPlace(work_);
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = work_[permuted ? place[i] : i];
  }

 private:
  Vector pivots_, work_;
};

}}  // namespace phistep::PHISTEP_ABI
