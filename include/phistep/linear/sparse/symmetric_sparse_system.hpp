/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K where it is symmetric, sparse: by a promise, `symmetric(f)`, or by what is found.
///
/// LDLᵀ without pivoting serves while W is positive definite, which D > 0 shows: half the work of LU and less fill. It
/// reads the lower triangle alone, so that symmetry is checked at each factorization: one pass over the entries.
///
/// Promised: an unsymmetric W is an error. Where W is indefinite (compressed springs) or nearly singular, an LU with pivoting
/// of the same W serves for that factorization, counted in Statistics::fallbacks; LDLᵀ is tried again at the next.
///
/// Sought: LDLᵀ from the first factorization on, if pattern and values are symmetric; LU from the first W on that is
/// unsymmetric or indefinite, one fallback where LDLᵀ had been tried. Values are compared at the accuracy they have: some
/// roundings where the force supplies them, some √u where they are differences. A solve that isn't iterated takes the first
/// kind only: there, what the upper triangle says otherwise would be an error.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include <cmath>
#include <limits>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/linear/sparse/cholesky_solve.hpp"
#include "phistep/linear/sparse/own_solver.hpp"
#include "phistep/linear/sparse/sparse_assembly.hpp"
#include "phistep/step/matrix/choice.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// How a system knows that its matrix is symmetric.
enum class Symmetry { promised, sought };

/// @tparam differenced  K and C are differences, and symmetric no closer than these are exact
template <class Scalar, Symmetry symmetry, bool differenced, bool has_K = true, bool has_C = true>
class SymmetricSparseSystem : public SparseAssembly<Scalar, has_K, has_C, symmetry == Symmetry::promised> {
  using Assembly = SparseAssembly<Scalar, has_K, has_C, symmetry == Symmetry::promised>;
  static constexpr bool sought = symmetry == Symmetry::sought;

 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;

  void resize(Eigen::Index n) {
    Assembly::resize(n);
    forget_pattern();
  }

  /// False in a copy.
  [[nodiscard]] bool has_solver() const { return definite_ ? static_cast<bool>(ldlt_) : static_cast<bool>(lu_); }
  /// LDLᵀ may serve again: the force may be another one.
  void begin_anew() requires(sought) { by_lu_ = is_known_ = false; }
  [[nodiscard]] const char* name() const requires(sought) {
    return !is_known_ ? "sparse LDLT or LU" : definite_ ? "sparse LDLT, found symmetric" : "sparse LU";
  }

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
    Assembly::forget_pattern();
    if constexpr (sought) begin_anew();
  }

 private:
  [[nodiscard]] Outcome try_to_factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift,
                                         Statistics& statistics) {
    if (!ldlt_ && !lu_) Assembly::forget_pattern();  // a copy's: it has to make solvers of its own
    if (this->update_pattern(masses)) {
      ldlt_.drop();
      lu_.drop();
    }
    this->assemble(masses, gamma_force, gamma_drift);
    if constexpr (sought) {
      ++statistics.factorizations;
      is_known_ = true;
      const bool has_served = definite_ && !by_lu_;
      definite_ = false;  // an exception leaves no factors
      const bool is_tried = !by_lu_ && this->is_symmetric(tolerance());
      definite_ = is_tried && factorize_definite(statistics);
      if (definite_) return Outcome::success;
      if (is_tried || has_served) ++statistics.fallbacks;
      by_lu_ = true;
      ldlt_.drop();
    } else {
      if (!this->is_symmetric(tolerance())) return Outcome::not_symmetric;
      ++statistics.factorizations;
      definite_ = factorize_definite(statistics);
      if (definite_) return Outcome::success;
      ++statistics.fallbacks;
    }
    return factorize_by_lu(statistics);
  }

  /// Entries are sums whose terms may be added in another order than their transposes' and cancel to a thousandth; a
  /// broken promise shows in the first digits. Differences have half of the digits, less where a force bends strongly. Without
  /// a promise the bound is tighter.
  [[nodiscard]] static Scalar tolerance() {
    constexpr Scalar epsilon = std::numeric_limits<Scalar>::epsilon();
    if constexpr (sought) return differenced ? 64 * std::sqrt(epsilon) : 16 * epsilon;
    else return differenced ? std::sqrt(std::sqrt(epsilon)) : 1024 * epsilon;
  }
  /// False where a pivot isn't positive, or is nothing but the rounding of what it is the rest of.
  [[nodiscard]] bool factorize_definite(Statistics& statistics) {
    const Eigen::Index n = this->matrix().cols();
    for (Eigen::Index i = 0; i < n; ++i)
      if (!(this->diagonal(i) > Scalar{0})) return false;
    if (!ldlt_) {
      ldlt_.make();
      ldlt_->analyzePattern(this->matrix());
      ++statistics.analyses;
    }
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
  bool definite_ = false;                          // the last factors are LDLᵀ
  bool by_lu_ = false, is_known_ = false;          // sought: LU from now on; W has been looked at
};

template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::symmetric_sparse, facts, Scalar, Solver, Force> {
  using type = SymmetricSparseSystem<Scalar, Symmetry::promised, facts.differenced, facts.has_K, facts.has_C>;
};
/// Differences of an affine force are as exact as what it could supply.
template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::sparse_either, facts, Scalar, Solver, Force> {
  using type =
      SymmetricSparseSystem<Scalar, Symmetry::sought, facts.differenced && !facts.constant, facts.has_K, facts.has_C>;
};

}}  // namespace phistep::PHISTEP_ABI
