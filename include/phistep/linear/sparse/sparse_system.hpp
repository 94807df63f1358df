/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K, sparse: by LU, by LDLᵀ where it is symmetric, or over any solver with
/// Eigen's interface.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <vector>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/linear/lanes/lane_system.hpp"
#include "phistep/linear/sparse/sparse_assembly.hpp"
#include "phistep/linear/sparse/sparse_lu.hpp"
#include "phistep/step/matrix/choice.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Eigen::SimplicialLLT, Eigen::SimplicialLDLT.
template <class Solver>
concept SimplicialFactors = requires(const Solver& solver) {
  solver.matrixL();
  solver.matrixU();
  solver.permutationP();
};

/// One of these that solves Pᵀ L D Lᵀ P x = b (D = 1 for LLᵀ) without a vector for the result and a mask for P.
template <class Solver>
class CholeskyInPlace : public Solver {
 public:
  using Vector = Eigen::Matrix<typename Solver::Scalar, Eigen::Dynamic, 1>;

  /// Eigen hands D out by value only: one copy a factorization instead of one a solve.
  void factorize(const auto& W) {
    Solver::factorize(W);
    if constexpr (requires { this->vectorD(); }) pivots_ = this->vectorD();
  }
  /// D, in the order of elimination; empty for LLᵀ.
  [[nodiscard]] const Vector& pivots() const { return pivots_; }

  void solve_in_place(auto& x) {
    work_.resize(x.size());
    const auto& place = this->permutationP().indices();
    const bool permuted = place.size() > 0;  // not where the user chose the natural ordering
    for (Eigen::Index i = 0; i < x.size(); ++i) work_[permuted ? place[i] : i] = x[i];
    this->matrixL().solveInPlace(work_);
    if constexpr (requires { this->vectorD(); }) work_.array() /= pivots_.array();
    this->matrixU().solveInPlace(work_);
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = work_[permuted ? place[i] : i];
  }

 private:
  Vector pivots_, work_;
};

/// Sparse W over any solver with Eigen's interface (analyzePattern, factorize, solve, info).
template <class Scalar, class Solver, bool has_K = true, bool has_C = true>
class SparseSystem : public SparseAssembly<Scalar, has_K, has_C> {
  using Assembly = SparseAssembly<Scalar, has_K, has_C>;

 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;

  void resize(Eigen::Index n) {
    Assembly::resize(n);
    solver_.reset();
  }

  /// False in a copy.
  [[nodiscard]] bool has_solver() const { return static_cast<bool>(solver_); }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    if (!solver_) {
      solver_.reset(new Used);
      Assembly::forget_pattern();
    }
    try {
      if (this->settle(masses)) {
        solver_->analyzePattern(this->matrix());
        ++statistics.analyses;
      }
      this->assemble(masses, gamma_force, gamma_drift);
      ++statistics.factorizations;
      solver_->factorize(this->matrix());
    } catch (...) {  // of memory it didn't get: Eigen's solvers can't be used any more then
      solver_.reset();
      throw;
    }
    if (solver_->info() == Eigen::NumericalIssue)
      return SimplicialFactors<Solver> ? Outcome::not_positive_definite : Outcome::singular_matrix;
    if (solver_->info() != Eigen::Success) return Outcome::linear_solver_failed;
    // SimplicialLDLT doesn't pivot and calls an indefinite matrix a success.
    if constexpr (SimplicialFactors<Solver>)
      for (const Scalar pivot : solver_->pivots())
        if (!(pivot > Scalar{0})) return Outcome::not_positive_definite;
    return Outcome::success;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    if constexpr (requires { solver_->solve_in_place(x); }) {
      solver_->solve_in_place(x);
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
  /// Forgets the symbolic analysis of the pattern.
  void forget_pattern() { solver_.reset(); }

 private:
  using Used = std::conditional_t<SimplicialFactors<Solver>, CholeskyInPlace<Solver>, Solver>;
  static constexpr bool iterates = requires(const Solver& solver) { solver.iterations(); };

  OwnSolver<Used> solver_;
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> work_;
};

/// LU unless the user names a solver: right for every tangent, symmetric or not.
template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::sparse, facts, Scalar, Solver, Force> {
  using type = SparseSystem<Scalar, SparseLu<Scalar>, facts.has_K, facts.has_C>;
};
template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::own, facts, Scalar, Solver, Force> {
  using type = SparseSystem<Scalar, Solver, facts.has_K, facts.has_C>;
};

/// How a system knows that its matrix is symmetric.
enum class Symmetry { promised, sought };

/// Symmetric sparse W: by a promise, `symmetric(f)`, or by what is found.
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
///
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
  void begin_anew() { by_lu_ = is_known_ = false; }
  [[nodiscard]] const char* name(const char* of_row) const {
    return !sought || !is_known_ ? of_row : definite_ ? "sparse LDLT, found symmetric" : "sparse LU";
  }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    try {
      if (!ldlt_ && !lu_) Assembly::forget_pattern();  // a copy's: it has to make solvers of its own
      if (this->settle(masses)) {
        ldlt_.reset();
        lu_.reset();
      }
      this->assemble(masses, gamma_force, gamma_drift);
      const bool has_served = definite_ && !by_lu_;
      definite_ = false;  // an exception leaves no factors
      const bool is_tried = !by_lu_ && this->is_symmetric(tolerance());
      if (!sought && !is_tried) return Outcome::not_symmetric;
      ++statistics.factorizations;
      is_known_ = true;
      definite_ = is_tried && factorize_definite(statistics);
      if (definite_) return Outcome::success;
      if (is_tried || has_served) ++statistics.fallbacks;
      if (by_lu_ = sought; by_lu_) ldlt_.reset();
      return factorize_by_lu(statistics);
    } catch (...) {  // of failed allocations: Eigen's solvers can't be used after one
      forget_pattern();
      throw;
    }
  }
  [[nodiscard]] Outcome solve(auto& x) {
    if (definite_) ldlt_->solve_in_place(x);
    else lu_->solve_in_place(x);
    return Outcome::success;
  }
  /// Forgets the pattern and the symbolic analyses of it.
  void forget_pattern() {
    ldlt_.reset();
    lu_.reset();
    Assembly::forget_pattern();
    begin_anew();
  }

 private:
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
      ldlt_.reset(new Ldlt);
      ldlt_->analyzePattern(this->matrix());
      ++statistics.analyses;
    }
    ldlt_->factorize(this->matrix());
    if (ldlt_->info() != Eigen::Success) return false;
    const auto& place = ldlt_->permutationP().indices();
    for (Eigen::Index i = 0; i < n; ++i)
      if (!(ldlt_->pivots()[place[i]] > 16 * std::numeric_limits<Scalar>::epsilon() * this->diagonal(i))) return false;
    return true;
  }
  [[nodiscard]] Outcome factorize_by_lu(Statistics& statistics) {
    if (!lu_) {
      lu_.reset(new SparseLu<Scalar>);
      lu_->analyzePattern(this->matrix());
      ++statistics.analyses;
    }
    lu_->factorize(this->matrix());
    return lu_->info() == Eigen::Success ? Outcome::success : Outcome::singular_matrix;
  }

  using Ldlt = CholeskyInPlace<Eigen::SimplicialLDLT<Matrix>>;
  OwnSolver<Ldlt> ldlt_;
  OwnSolver<SparseLu<Scalar>> lu_;         // made where it is needed first
  bool definite_ = false;                  // the last factors are LDLᵀ
  bool by_lu_ = false, is_known_ = false;  // by LU from now on; W's kind has been found
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

/// Several shifted matrices at once: an analysis for each pattern, none for new values.
template <SystemKind kind, MatrixFacts facts, class Scalar, int lanes>
  requires(kind == SystemKind::sparse || kind == SystemKind::symmetric_sparse)
class LaneSystem<kind, facts, Scalar, lanes> {
 public:
  using Shift = LaneShift<Scalar, lanes>;
  using Number = typename Shift::Number;

  void resize(Eigen::Index) { forget_pattern(); }
  void forget_pattern() { W_.clear(); }
  [[nodiscard]] Outcome factorize(auto& system, const auto& masses, const Shift& shift, Statistics& statistics) {
    if (system.settle(masses) || W_.empty()) {
      forget_pattern();
      lu_.analyzePattern(system.pattern());
      ++statistics.analyses;
      W_.resize(static_cast<std::size_t>(system.pattern().nonZeros()));
    }
    system.for_each_tangent(
        [&](std::size_t slot, Scalar K, Scalar C) { W_[slot] = shift.template of_tangents<facts>(K, C); });
    system.for_each_mass(masses, [&](std::size_t slot, Scalar m) { shift.add_mass(W_[slot], m); });
    ++statistics.factorizations;
    return lu_.factorize(system.pattern(), W_.data()) ? Outcome::success : Outcome::singular_matrix;
  }
  void solve_in_place(Number* x) { lu_.solve_in_place(x); }
  static void add_position_product(auto& system, Scalar factor, const auto& x, auto& out) {
    system.add_position_product(factor, x, out);
  }

 private:
  std::vector<Number> W_;  // by slot of the pattern, empty before the analysis
  SparseLu<Number> lu_;
};

}}  // namespace phistep::PHISTEP_ABI
