/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K, sparse, solved by a preconditioned Krylov method:
///
///     newton<PreconditionedBySymmetry>()                          conjugate gradients or BiCGSTAB (eisenstat.hpp)
///     newton<PreconditionedCg<IncompleteCholesky>>()              W symmetric positive definite
///     newton<PreconditionedBicgstab<Eigen::IncompleteLUT<double>>>()
///     newton<PreconditionedGmres<>>()                             by W's diagonal
///
/// A preconditioner is a class with the interface of Eigen's: analyzePattern(W) for each new pattern, factorize(W), solve(b),
/// info(); with solve_in_place(x) no vector is made. It need not fit W: the same one serves for the next W while γ stays
/// within a factor of two of the one it was made for and the iterations don't double. One that has factorize(W, γ_f, γ_d) in
/// place of factorize(W) is called for every W, and decides for itself, as a multigrid that keeps its hierarchy.
/// Statistics::factorizations counts these calls.
///
/// A controlled run says how well each solve has to be done: the preconditioned residual, in the run's norm, is to be a
/// twentieth of what the nonlinear solve may leave (A. C. Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005) 363, sect. 2.1).
/// Without one, a relative residual counts, NewtonOptions::linear_rtol.
#pragma once

#include <Eigen/Core>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include <algorithm>
#include <concepts>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/linear/krylov/eisenstat.hpp"
#include "phistep/linear/krylov/methods.hpp"
#include "phistep/linear/sparse/sparse_assembly.hpp"
#include "phistep/step/matrix/choice.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Eigen's, without a permutation: on grids numbered row by row it needs fewer iterations than with one.
using IncompleteCholesky = Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::NaturalOrdering<int>>;

/// The last argument of a stepper, `newton<PreconditionedCg<P>>()`, or with a preconditioner that holds something,
/// `newton(PreconditionedCg<P>{mine})`, which is copied.
template <KrylovMethod which, class P>
struct PreconditionedKrylov {
  static constexpr KrylovMethod method = which;
  using Preconditioner = P;
  static constexpr bool is_copied = std::copy_constructible<P>;
  [[no_unique_address]] Only<is_copied, P> preconditioner{};
};
/// Conjugate gradients, for symmetric positive definite W.
template <class P = Eigen::DiagonalPreconditioner<double>>
using PreconditionedCg = PreconditionedKrylov<KrylovMethod::conjugate_gradients, P>;
/// BiCGSTAB, for any W: two products an iteration.
template <class P = Eigen::DiagonalPreconditioner<double>>
using PreconditionedBicgstab = PreconditionedKrylov<KrylovMethod::bicgstab, P>;
/// GMRES, for any W: restarted after 30 vectors.
template <class P = Eigen::DiagonalPreconditioner<double>>
using PreconditionedGmres = PreconditionedKrylov<KrylovMethod::gmres, P>;

/// Conjugate gradients while W is symmetric, BiCGSTAB elsewhere, both with incomplete factors that differ from W on the diagonal
/// alone; of a W whose pattern is unsymmetric BiCGSTAB with W's diagonal.
using PreconditionedBySymmetry = PreconditionedKrylov<KrylovMethod::by_symmetry, Eigen::DiagonalPreconditioner<double>>;

template <KrylovMethod method, class P>
inline constexpr bool is_preconditioned_krylov<PreconditionedKrylov<method, P>> = true;

template <class Scalar, class Linear, bool has_K = true, bool has_C = true>
class PreconditionedSystem : public SparseAssembly<Scalar, has_K, has_C> {
  using Assembly = SparseAssembly<Scalar, has_K, has_C>;
  using P = typename Linear::Preconditioner;

 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  static constexpr bool is_symmetric = Linear::method == KrylovMethod::conjugate_gradients,
                        is_either = Linear::method == KrylovMethod::by_symmetry;

  void take(const Linear& linear) { given_ = linear; }
  void resize(Eigen::Index n) {
    Assembly::resize(n);
    drop();
  }
  /// False in a copy that has a preconditioner to make.
  [[nodiscard]] bool has_solver() const { return fits_ || p_; }
  void forget_pattern() {
    drop();
    Assembly::forget_pattern();
  }
  /// The pattern of the Jacobian at hand, before there is a W: its analysis waits for the first one.
  [[nodiscard]] bool settle(const auto& masses) {
    is_settled_ = Assembly::settle(masses) || is_settled_;
    return is_settled_;
  }
  /// The next W gets a preconditioner of its own.
  void begin_anew() { is_tired_ = true; }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    try {
      if (!has_solver() && !is_settled_) Assembly::forget_pattern();
      const bool is_new = settle(masses);
      is_settled_ = false;
      this->assemble(masses, gamma_force, gamma_drift);
      if constexpr (is_either) {
        if (is_new) {
          p_.reset();
          fits_ = eisenstat_.analyze(this->matrix());
          if (fits_) ++statistics.analyses;
        }
        if (fits_) {
          ++statistics.factorizations;
          return eisenstat_.factorize(this->matrix()) ? Outcome::success : Outcome::not_positive_definite;
        }
      }
      return precondition_anew(is_new || !p_, gamma_force, gamma_drift, statistics);
    } catch (...) {
      drop();
      throw;
    }
  }

  /// x ← W⁻¹ x to a relative residual. @param rtol  0: 1e-4
  [[nodiscard]] Outcome solve(auto& x, double rtol, Statistics& statistics) {
    if (rtol == 0) rtol = 1e-4;
    weights_.resize(0);
    const Scalar by = to_unit_size(max_abs(x));
    b_ = by * x;
    const Scalar size = b_.norm();
    x.setZero();
    if (size == Scalar{0}) return Outcome::success;
    r_ = b_;
    // (1) is a size of the error; that of the residual itself decides here.
    double left = 1;
    for (int round = 0; round < 6; ++round) {
      if (const Outcome bad = iterate({0, std::min(0.5, 0.5 * rtol / left)}, x, statistics); failed(bad)) return bad;
      multiply(x, r_);
      r_ = b_ - r_;
      left = static_cast<double>(r_.norm() / size);
      if (left <= rtol) break;
    }
    x /= by;
    return left <= rtol ? Outcome::success : Outcome::linear_solver_failed;
  }
  /// x ← W⁻¹ x to an error of about `absolute` in the weighted norm. @param weigh  weigh(w) sets the weights
  [[nodiscard]] Outcome solve_within(auto& x, double absolute, auto&& weigh, Statistics& statistics) {
    const KrylovGoal goal{absolute, 8 * static_cast<double>(Eigen::NumTraits<Scalar>::epsilon())};
    if constexpr (is_either)
      if (fits_) return finish(eisenstat_.solve_within(with_limit(goal, x.size()), x, weigh), x, statistics);
    weights_.resize(x.size());
    weigh(weights_);
    r_ = x;
    x.setZero();
    return iterate(goal, x, statistics);
  }

  /// x ← P⁻¹ x, b ← W x
  void approximate(auto& x, auto& b) {
    if constexpr (is_either)
      if (fits_) {
        eisenstat_.precondition(x);
        return multiply(x, b);
      }
    precondition(x, b);
    x = b;
    multiply(x, b);
  }

  // For the methods.
  void multiply(const auto& x, auto& out) const {
    if constexpr (is_symmetric) out.noalias() = this->matrix().transpose() * x;  // by dot products
    else out.noalias() = this->matrix() * x;
  }
  void precondition(const auto& x, auto& out) const {
    if constexpr (requires { p_->solve_in_place(out); }) {
      out = x;
      p_->solve_in_place(out);
    } else {
      out = p_->solve(x);
    }
  }
  [[nodiscard]] const Vector& weights() const { return weights_; }

 private:
  void drop() {
    p_.reset();
    fits_ = false;
  }
  [[nodiscard]] Outcome precondition_anew(bool is_due, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    if (is_due) {
      if constexpr (Linear::is_copied) p_.reset(new P(given_.preconditioner));
      else p_.reset(new P);
      if constexpr (requires { p_->analyzePattern(this->matrix()); }) p_->analyzePattern(this->matrix());
      iteration_.resize(this->matrix().cols());
      ++statistics.analyses;
    }
    const Scalar ratio = gamma_force / made_for_;
    is_due = is_due || is_tired_ || !(ratio >= Scalar{0.5} && ratio <= Scalar{2});
    constexpr bool is_told = requires { p_->factorize(this->matrix(), gamma_force, gamma_drift); };
    if constexpr (is_told) p_->factorize(this->matrix(), gamma_force, gamma_drift);
    else if (is_due) p_->factorize(this->matrix());
    else return Outcome::success;
    ++statistics.factorizations;
    made_for_ = gamma_force;
    is_tired_ = false;
    usual_ = -1;
    if constexpr (requires { p_->info(); })
      if (p_->info() != Eigen::Success) {
        is_tired_ = true;
        return is_symmetric ? Outcome::not_positive_definite : Outcome::linear_solver_failed;
      }
    return Outcome::success;
  }
  [[nodiscard]] static KrylovGoal with_limit(KrylovGoal goal, Eigen::Index n) {
    goal.max_iterations = static_cast<int>(std::clamp<Eigen::Index>(2 * n, 10, 1000));
    return goal;
  }
  [[nodiscard]] Outcome iterate(KrylovGoal goal, auto& x, Statistics& statistics) {
    goal = with_limit(goal, x.size());
    if constexpr (is_either)
      if (fits_) return finish(eisenstat_.solve(goal, r_, x), x, statistics);
    return finish(iteration_.solve(*this, goal, r_, x), x, statistics);
  }
  [[nodiscard]] Outcome finish(const KrylovEnd& end, const auto& x, Statistics& statistics) {
    statistics.linear_iterations += end.iterations;
    if (usual_ < 0) usual_ = end.iterations;
    else if (end.iterations > 2 * usual_ + 4) is_tired_ = true;
    if (end.converged) return Outcome::success;
    is_tired_ = true;
    return all_finite(x.data(), x.size()) ? Outcome::linear_solver_failed : Outcome::singular_matrix;
  }

  Linear given_;
  [[no_unique_address]] Only<is_either, Eisenstat<Scalar>> eisenstat_;  // used where it takes W's pattern
  OwnSolver<P> p_;                                                      // elsewhere
  KrylovIteration<Scalar, is_either ? KrylovMethod::bicgstab : Linear::method> iteration_;
  Vector r_, b_, weights_;
  Scalar made_for_{};        // γ_f
  int usual_ = -1;           // iterations of the first solve with this preconditioner
  bool is_tired_ = false;    // it wants to be made anew
  bool fits_ = false;        // eisenstat_ serves W's pattern
  bool is_settled_ = false;  // the pattern waits for its analysis
};

template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::preconditioned, facts, Scalar, Solver, Force> {
  using type = PreconditionedSystem<Scalar, Solver, facts.has_K, facts.has_C>;
};

}}  // namespace phistep::PHISTEP_ABI
