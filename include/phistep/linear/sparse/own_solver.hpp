/// @file
/// Eigen's sparse solvers as members of what is copied and solves often: they can be neither copied nor shared, and their
/// solve() allocates.
#pragma once

#include <Eigen/Core>

#include <memory>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Owns a solver; its copy owns none, and makes its own at its next solve. Sharing one would let two steppers overwrite each
/// other.
template <class Solver>
class OwnSolver {
 public:
  OwnSolver() = default;
  OwnSolver(const OwnSolver&) {}
  OwnSolver(OwnSolver&&) noexcept = default;
  OwnSolver& operator=(const OwnSolver&) {
    drop();
    return *this;
  }
  OwnSolver& operator=(OwnSolver&&) noexcept = default;
  ~OwnSolver() = default;

  void make(const auto&... from) { value_ = std::make_unique<Solver>(from...); }
  void drop() { value_ = nullptr; }
  [[nodiscard]] Solver& operator*() const { return *value_; }
  [[nodiscard]] Solver* operator->() const { return value_.get(); }
  [[nodiscard]] explicit operator bool() const { return value_ != nullptr; }

 private:
  std::unique_ptr<Solver> value_;
};

/// Eigen::SimplicialLLT, Eigen::SimplicialLDLT.
template <class Solver>
concept SimplicialFactors = requires(const Solver& solver) {
  solver.matrixL();
  solver.matrixU();
  solver.permutationP();
  solver.permutationPinv();
};

/// Solves Pᵀ L D Lᵀ P x = b (D = 1 for LLᵀ) without a vector for the result and a mask for P. read(solver) after each
/// factorization, then solve_in_place(solver, x).
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
