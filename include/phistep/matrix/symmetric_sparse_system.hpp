/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K of a force that promises symmetric tangents, sparse.
///
/// LDLᵀ without pivoting serves while W is positive definite, which D > 0 tells: half the work of LU and less fill. It
/// reads the lower triangle alone, so that the promise is checked at each factorization. Where W is indefinite (compressed
/// springs) or nearly singular, an LU with pivoting of the same W serves for that factorization, counted in
/// Statistics::fallbacks; LDLᵀ is tried again at the next.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include <cmath>
#include <limits>

#include "phistep/core/outcome.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/linear/cholesky_solve.hpp"
#include "phistep/matrix/choice.hpp"
#include "phistep/matrix/dense_system.hpp"
#include "phistep/matrix/own_solver.hpp"
#include "phistep/matrix/sparse_assembly.hpp"

namespace phistep::inline PHISTEP_ABI {

/// @tparam differenced  K and C are differences, and symmetric no closer than these are exact
template <class Scalar, bool differenced>
class SymmetricSparseSystem : public SparseAssembly<Scalar, true> {
  using Assembly = SparseAssembly<Scalar, true>;

 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;

  void resize(Eigen::Index n) {
    Assembly::resize(n);
    forget_pattern();
  }

  /// False in a copy.
  [[nodiscard]] bool has_solver() const { return static_cast<bool>(ldlt_); }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    try {
      return try_to_factorize(masses, gamma_force, gamma_drift, statistics);
    } catch (...) {  // of memory they didn't get: Eigen's solvers can't be used any more then
      forget_pattern();
      throw;
    }
  }
  [[nodiscard]] Outcome solve(auto& x) {
    if (definite_) {
      by_ldlt_.solve_in_place(*ldlt_, x);
      return Outcome::success;
    }
    work_ = lu_->solve(x);
    x = work_;
    return lu_->info() == Eigen::Success ? Outcome::success : Outcome::linear_solver_failed;
  }
  /// … and its analyses.
  void forget_pattern() {
    ldlt_.drop();
    lu_.drop();
  }

 private:
  [[nodiscard]] Outcome try_to_factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift,
                                         Statistics& statistics) {
    if (!ldlt_) {
      ldlt_.make();
      Assembly::forget_pattern();
    }
    if (this->update_pattern(masses)) {
      ldlt_->analyzePattern(this->matrix());
      lu_.drop();
      ++statistics.analyses;
    }
    this->assemble(gamma_force, gamma_drift);
    if (!this->is_symmetric(tolerance())) return Outcome::not_symmetric;
    ++statistics.factorizations;
    definite_ = factorize_definite();
    return definite_ ? Outcome::success : factorize_by_lu(statistics);
  }

  /// Entries are sums whose terms may be added in another order than their transposes' and cancel to a thousandth; a
  /// broken promise shows in the first digits. Differences have half of the digits, less where a force bends strongly.
  [[nodiscard]] static Scalar tolerance() {
    constexpr Scalar epsilon = std::numeric_limits<Scalar>::epsilon();
    return differenced ? std::sqrt(std::sqrt(epsilon)) : 1024 * epsilon;
  }
  /// False where a pivot isn't positive, or is nothing but the rounding of what it is the rest of.
  [[nodiscard]] bool factorize_definite() {
    const Eigen::Index n = this->matrix().cols();
    for (Eigen::Index i = 0; i < n; ++i)
      if (!(this->diagonal(i) > Scalar{0})) return false;
    ldlt_->factorize(this->matrix());
    if (ldlt_->info() != Eigen::Success) return false;
    const auto& place = ldlt_->permutationP().indices();
    by_ldlt_.read(*ldlt_);
    for (Eigen::Index i = 0; i < n; ++i)
      if (!(by_ldlt_.pivots()[place[i]] > 16 * std::numeric_limits<Scalar>::epsilon() * this->diagonal(i)))
        return false;
    return true;
  }
  [[nodiscard]] Outcome factorize_by_lu(Statistics& statistics) {
    ++statistics.fallbacks;
    if (!lu_) {
      lu_.make();
      lu_->analyzePattern(this->matrix());
      ++statistics.analyses;
    }
    lu_->factorize(this->matrix());
    return lu_->info() == Eigen::Success ? Outcome::success : Outcome::singular_matrix;
  }

  OwnSolver<Eigen::SimplicialLDLT<Matrix>> ldlt_;
  OwnSolver<Eigen::SparseLU<Matrix>> lu_;  // made where it is needed first
  CholeskySolve<Scalar> by_ldlt_;
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> work_;  // of LU
  bool definite_ = false;
};

template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::symmetric_sparse, facts, Scalar, Solver, Force> {
  using type = SymmetricSparseSystem<Scalar, facts.differenced>;
};

}  // namespace phistep::inline PHISTEP_ABI
