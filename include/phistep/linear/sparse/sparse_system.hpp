/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K, sparse, over any solver with Eigen's interface.
#pragma once

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include <type_traits>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/linear/sparse/cholesky_solve.hpp"
#include "phistep/linear/sparse/own_solver.hpp"
#include "phistep/linear/sparse/sparse_assembly.hpp"
#include "phistep/step/matrix/choice.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Sparse W over any solver with Eigen's interface (analyzePattern, factorize, solve, info).
template <class Scalar, class Solver, bool has_K = true, bool has_C = true>
class SparseSystem : public SparseAssembly<Scalar, has_K, has_C> {
  using Assembly = SparseAssembly<Scalar, has_K, has_C>;

 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;

  void resize(Eigen::Index n) {
    Assembly::resize(n);
    solver_.drop();
  }

  /// False in a copy.
  [[nodiscard]] bool has_solver() const { return static_cast<bool>(solver_); }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    if (!solver_) {
      solver_.make();
      Assembly::forget_pattern();
    }
    try {
      if (this->update_pattern(masses)) {
        solver_->analyzePattern(this->matrix());
        ++statistics.analyses;
      }
      this->assemble(masses, gamma_force, gamma_drift);
      ++statistics.factorizations;
      solver_->factorize(this->matrix());
    } catch (...) {  // of memory it didn't get: Eigen's solvers can't be used any more then
      solver_.drop();
      throw;
    }
    if (solver_->info() == Eigen::NumericalIssue) return failure_of_factors();
    if (solver_->info() != Eigen::Success) return Outcome::linear_solver_failed;
    if constexpr (SimplicialFactors<Solver>) {
      work_.read(*solver_);
      // SimplicialLDLT doesn't pivot and calls an indefinite matrix a success.
      for (const Scalar pivot : work_.pivots())
        if (!(pivot > Scalar{0})) return Outcome::not_positive_definite;
    }
    return Outcome::success;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    if constexpr (SimplicialFactors<Solver>) {
      work_.solve_in_place(*solver_, x);
    } else if constexpr (iterates) {
      const Scalar by = to_unit_size(max_abs(x));  // the solver squares it
      x *= by;
      work_ = solver_->solve(x);
      x = work_ / by;
    } else {
      work_ = solver_->solve(x);
      x = work_;
    }
    return solver_->info() == Eigen::Success ? Outcome::success : Outcome::linear_solver_failed;
  }
  /// … and its analysis.
  void forget_pattern() { solver_.drop(); }

 private:
  static constexpr bool iterates = requires(const Solver& solver) { solver.iterations(); };

  [[nodiscard]] static Outcome failure_of_factors() {
    return SimplicialFactors<Solver> ? Outcome::not_positive_definite : Outcome::singular_matrix;
  }

  OwnSolver<Solver> solver_;
  std::conditional_t<SimplicialFactors<Solver>, CholeskySolve<Scalar>, Eigen::Matrix<Scalar, Eigen::Dynamic, 1>> work_;
};

/// LU unless the user names a solver: right for every tangent, symmetric or not.
template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::sparse, facts, Scalar, Solver, Force> {
  using type = SparseSystem<Scalar, Eigen::SparseLU<Eigen::SparseMatrix<Scalar>>, facts.has_K, facts.has_C>;
};
template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::own, facts, Scalar, Solver, Force> {
  using type = SparseSystem<Scalar, Solver, facts.has_K, facts.has_C>;
};

}}  // namespace phistep::PHISTEP_ABI
