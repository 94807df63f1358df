/// @file
/// The only implicit solve there is: given b and γ, find Y with
///
///     M (Y − b) = γ_f Ψ(t, Y),     and for motion  Y.r = b.r + γ_d Y.v,                                        (1)
///
/// by Newton on the increment w = Y − b of the solved blocks alone, with the matrix W = M − γ_f C − γ_f γ_d K. An affine
/// force needs one linear solve and no iteration; a linearly implicit step is content with one.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <utility>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/jacobian/tangent_check.hpp"
#include "phistep/step/solve/increment.hpp"
#include "phistep/step/solve/linearization.hpp"
#include "phistep/step/solve/newton.hpp"
#include "phistep/step/solve/residual.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a resolvent need not have, and those without a matrix don't.
struct ResolventDefaults {
  static constexpr bool checks_state = false;       ///< success of resolve() says that Y is finite, and so was b
  static constexpr bool solves_by_factors = false;  ///< of one W, so that W⁻¹x is exact
  static void forget() {}
  static void reset() {}
  [[nodiscard]] static bool keeps_factors() { return false; }
  [[nodiscard]] static bool wants_differences() { return false; }
  [[nodiscard]] static bool is_mild() { return false; }
  [[nodiscard]] static Outcome filter(const auto&...) { return Outcome::success; }
  /// x = W⁻¹ of a residual. Without a W of all unknowns Newton will find out, particle by particle.
  [[nodiscard]] static Outcome respond(const auto&...) { return Outcome::success; }
};

/// How often a resolve corrects its iterate.
enum class Corrections { until_converged, one };

template <State S, class Rhs, class LinearSolver, bool position = true,
          Corrections corrections = Corrections::until_converged>
class NewtonResolvent : public ResolventDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Matrix = Linearization<S, Rhs, LinearSolver, position, /*stages=*/false, /*shifted=*/false,
                               /*iterated=*/corrections != Corrections::one>;
  static constexpr bool solves_by_factors = !Matrix::is_iterative;
  static constexpr bool affine = Rhs::Traits::is_affine && !Matrix::matrix_free && !Matrix::follows_tolerance;
  /// One correction is all there is, with a J that the user answers for.
  static constexpr bool is_checked = corrections == Corrections::one && !affine && Matrix::is_promised;

  NewtonResolvent(const Plain& y, auto&& rhs, const auto& solver) : options_{solver.options} {
    // One solve is all there is: it has to be as good as the answer.
    if (Matrix::is_iterative && options_.linear_rtol == 0) {
      if (affine) options_.linear_rtol = std::max(1e-12, 16 * round_off);
      else if (corrections == Corrections::one) options_.linear_rtol = 1e-6;
    }
    matrix_.take(solver);
    resize(y, rhs);
  }

  void resize(const Plain& y, Rhs& rhs) {
    matrix_.resize(y, rhs);  // may throw, so it comes first
    increment_.resize(y);
    if constexpr (is_checked) check_.resize(y);
    forget();
  }

  /// What solves leave for the next one to judge its corrections by.
  struct Pace {
    double rate = 1;          ///< θ/(1−θ) of the controlled solves so far
    double gamma_before = 0;  ///< γ of the last; 0: there was none
    double first_rate = 0;    ///< θ of the last solve to rounding; 0: there was none
  };
  [[nodiscard]] Pace& pace() { return pace_; }

  /// Whether the next solve begins with differences, for which it has to know Ψ itself: one that a solve has left is off by
  /// what that solve is.
  [[nodiscard]] bool wants_differences() const { return Matrix::takes_differences && !matrix_.has_jacobian(); }
  /// Forgets Jacobian and factors.
  void drop() { matrix_.drop(); }
  /// Forgets all that solves have left.
  void forget() {
    matrix_.forget_solves();
    affine_solve_ = {};
    pace_ = {};
  }
  /// Forgets also what was found out about the force, which may be another one.
  void reset() {
    forget();
    matrix_.forget();
    if constexpr (is_checked) check_.begin();
  }
  /// Forgets also the matrix's pattern: the state after construction.
  void forget_unsaved() {
    reset();
    matrix_.forget_pattern();
  }

  /// @param Y  b at first, then what (1) is solved by
  /// @param knows_psi  psi holds Ψ at the start of the iteration already
  /// @param allowed  of a controlled run: says how well to solve, unless the options do
  [[nodiscard]] Outcome resolve(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, Plain& Y, const Plain& guess, Rate& psi,
                                SolveRecord& record, bool knows_psi = false, SolveTolerance<Plain> allowed = {}) {
    increment_.begin(Y, gamma.drift);
    if (options_.rtol > 0) allowed.target = 0;
    // Factors of a γ that is the same up to rounding (frames away from t = 0) serve always, to a tolerance those within
    // CVODE's bound.
    const bool is_tolerant = !affine && (options_.rtol > 0 || allowed.target > 0);
    matrix_.begin(gamma, is_tolerant ? Scalar{3} / 10 : static_cast<Scalar>(std::sqrt(round_off)));
    Iterate iterate{{rhs, gamma, t, psi, knows_psi, increment_}, *this, Y, guess, allowed};
    const Outcome outcome = solve(iterate, record);
    if (outcome == Outcome::singular_matrix) record.particle = matrix_.singular_particle();
    return outcome;
  }

  /// e.solved ← W⁻¹ M e.solved, with the last resolve's matrix.
  [[nodiscard]] Outcome filter(Rhs& rhs, Plain& e) {
    auto& x = increment_.delta;
    x.setZero();
    for_each_part([&x](Index at, const auto& block,
                       const auto& mass) { mass.subtract_product(-flat(block), part(x, at, block)); },
                  Blocks<S>::solved(std::as_const(e)), rhs.masses());
    return solve_roughly(rhs, e);
  }

  /// rate ← W⁻¹ γ rate, as unknowns in x, with W at (t, y), where Ψ is psi.
  [[nodiscard]] Outcome respond(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, const Plain& y, const Rate& psi,
                                const Rate& rate, Plain& x, const SolveTolerance<Plain>& allowed) {
    matrix_.begin(gamma, Scalar{0});
    if (!matrix_.has_factors())
      if (const Outcome bad = matrix_.refresh(rhs, gamma, t, y, psi, options_, allowed); failed(bad)) return bad;
    auto& of = increment_.delta;
    for_each_part([&](Index at, const auto& block) { part(of, at, block) = gamma.force * flat(block); },
                  Rate::blocks(rate));
    return solve_roughly(rhs, x);
  }

  /// W is M to a half: an iteration with it converges for what it is, and a filter by it hides nothing.
  [[nodiscard]] bool is_mild() const {
    const double largest = matrix_.magnitude();
    return Rhs::MassTypes::are_ones && largest > 0 && largest < 1.5;
  }
  [[nodiscard]] const auto& increment() const { return increment_.w; }
  [[nodiscard]] const char* solver_name() const { return matrix_.name(); }
  [[nodiscard]] static bool keeps_factors() { return true; }

 private:
  static constexpr double round_off = static_cast<double>(std::numeric_limits<Scalar>::epsilon());

  /// What solve_newton iterates on.
  struct Iterate : Residual<S, Rhs> {
    static constexpr bool is_inexact = Matrix::is_iterative;
    NewtonResolvent& self;
    Plain& Y;
    const Plain& guess;
    SolveTolerance<Plain> allowed;
    double square = -1;  // Σ (F_i weight_i)² of a field, −1: not known
    [[no_unique_address]] Only<FieldState<S>, Correction> correction{};  // the size of a field's last correction

    void restart() { this->increment.start(Y, guess); }
    [[nodiscard]] Outcome residual() {
      this->evaluate(Y);
      square = self.matrix_.square_of(this->increment.delta, self.options_, allowed);
      return square >= 0 ? Outcome::success : this->check();  // of a field the sum tells whether F is finite
    }
    [[nodiscard]] bool residual_is_noise() const {
      if constexpr (Matrix::matrix_free) return true;  // no matrix of an earlier iterate is ever used
      else return largest(this->F()) <= 8 * round_off * terms();
    }
    /// The size of what F is made of.
    [[nodiscard]] double terms() const {
      return this->all_terms(Y, guess, self.matrix_.magnitude(), self.matrix_.drift_share());
    }
    [[nodiscard]] bool has_jacobian() const { return self.matrix_.has_jacobian(); }
    [[nodiscard]] bool has_factors() const { return self.matrix_.has_factors(); }
    void drop_jacobian() { self.matrix_.drop(); }
    [[nodiscard]] Outcome refresh() {
      return self.matrix_.refresh(this->rhs, this->gamma, this->t, Y, this->psi, self.options_, allowed);
    }
    [[nodiscard]] Outcome solve() {
      return self.matrix_.solve(this->increment.delta, self.options_, this->rhs.statistics(), allowed);
    }
    /// For a field by one reduction: how large the correction is, and whether all ranks have solved for it.
    [[nodiscard, gnu::always_inline]] inline Outcome correct() {
      auto& matrix = self.matrix_;
      auto& counts = this->rhs.statistics();
      if (const Outcome bad = matrix.solve_unagreed(this->increment.delta, self.options_, counts, allowed, square);
          failed(bad))
        return bad;
      while (matrix.differences_reached_too_far(Y, this->increment.delta)) {
        this->assemble();
        if (const Outcome bad = refresh(); failed(bad)) return bad;
        if (const Outcome bad = solve(); failed(bad)) return bad;
      }
      this->increment.move(Y);
      if constexpr (FieldState<S>) {
        correction = size_of_move();
        if (!std::isfinite(correction.absolute)) return matrix.agree(Y);
      }
      return Outcome::success;
    }
    void retreat() { this->increment.retreat(Y); }
    void undo() { this->increment.undo(Y); }
    [[nodiscard]] Correction size() const {
      if constexpr (FieldState<S>) return correction;
      else return size_of_move();
    }
    [[nodiscard]] Correction size_of_move() const {
      if (allowed.target > 0) return this->increment.size(Y, allowed);
      return this->increment.size(Y, self.matrix_.drift_share(), self.options_);
    }
  };

  [[nodiscard]] Outcome solve(Iterate& iterate, SolveRecord& record) {
    if constexpr (affine) {
      return affine_solve_.solve<Rhs::drifts>(iterate, matrix_, increment_, options_.linear_rtol, round_off);
    } else if constexpr (corrections == Corrections::one) {
      matrix_.drop();
      iterate.restart();
      if (const Outcome bad = iterate.residual(); failed(bad)) return bad;
      if (const Outcome bad = iterate.refresh(); failed(bad)) return bad;
      if constexpr (is_checked) {
        check_.count();
        if (check_.is_due())
          if (const Outcome bad =
                  check_.look(iterate.rhs, matrix_, options_, iterate.gamma, iterate.t, iterate.Y, iterate.psi);
              failed(bad)) {
            check_.begin();
            return bad;
          }
      }
      return iterate.correct();
    } else {
      const int before = record.iterations;
      const Outcome outcome = iterate.allowed.target > 0
                                  ? solve_controlled(iterate, record)
                                  : solve_newton(iterate, options_, round_off, record, pace_.first_rate);
      iterate.rhs.statistics().iterations += record.iterations - before;
      return outcome;
    }
  }

  /// x.solved = W⁻¹ of what is in increment_.delta, to a few per cent by an iterative solver
  [[nodiscard]] Outcome solve_roughly(Rhs& rhs, Plain& x) {
    NewtonOptions roughly = options_;
    roughly.linear_rtol = 0.05;
    if (const Outcome bad = matrix_.solve(increment_.delta, roughly, rhs.statistics()); failed(bad)) return bad;
    put_unknowns<S>(increment_.delta, x);
    return Outcome::success;
  }

  /// Where a smaller step is at hand, plain Newton has one try.
  [[nodiscard]] Outcome solve_controlled(Iterate& iterate, SolveRecord& record) {
    // An old Jacobian contracts in proportion to γ, old factors no better than their own γ allows.
    const double gamma = std::abs(static_cast<double>(iterate.gamma.force));
    const double growth = pace_.gamma_before > 0 ? gamma / pace_.gamma_before : 1;
    pace_.gamma_before = gamma;
    const double rate = std::max(pace_.rate * std::max(1.0, growth), matrix_.staleness(iterate.gamma));
    ConvergenceTest test(iterate.allowed.target, options_.max_iterations, rate, round_off);
    const Outcome outcome =
        iterate_or_start_anew(iterate, test, keep_jacobian_rate({.rtol = 1}), options_.line_search, record);
    pace_.rate = outcome == Outcome::success ? test.rate() : 1;
    return outcome;
  }

  NewtonOptions options_;
  Increment<S> increment_;
  Matrix matrix_;
  Pace pace_;
  AffineSolve affine_solve_;
  [[no_unique_address]] Only<is_checked, TangentCheck<S, Rhs>> check_;
};

/// What serves a kernel's resolves; where solves leave anything, it has forget_unsaved(), too.
template <class Resolvent, class S, class Rhs>
concept Resolves = requires(Resolvent& one, Rhs& rhs, const Gamma<ScalarOf<S>>& gamma, ScalarOf<S> t, PlainState<S>& Y,
                            const PlainState<S>& guess, RateOf<S>& psi, SolveRecord& record) {
  {
    one.resolve(rhs, gamma, t, Y, guess, psi, record, false, SolveTolerance<PlainState<S>>{})
    } -> std::same_as<Outcome>;                     // in: Y = b; an iteration starts from the guess's solved blocks
  { one.filter(rhs, Y) } -> std::same_as<Outcome>;  // of an error estimate, with the last resolve's matrix
  { one.increment() } -> std::convertible_to<typename UnknownsOf<S>::type>;  // Y − b of the last resolve
  { one.keeps_factors() } -> std::same_as<bool>;       // whether a constant Δt spares factorizations
  { one.solver_name() } -> std::same_as<const char*>;  // how the linear equations inside are solved
  one.resize(guess, rhs);
  one.forget();  // what solves have left
  one.reset();   // forgets also what was found out about the force
};

/// The resolvent behind each way to solve: Newton's here, others in headers of their own.
template <State S, class Rhs, class Solver, bool position>
struct ResolventFor;
template <State S, class Rhs, class LinearSolver, bool position>
struct ResolventFor<S, Rhs, Newton<LinearSolver>, position> {
  using type = NewtonResolvent<S, Rhs, LinearSolver, position>;
};
template <State S, class Rhs, class LinearSolver, bool position>
struct ResolventFor<S, Rhs, LinearlyImplicit<LinearSolver>, position> {
  using type = NewtonResolvent<S, Rhs, LinearSolver, position, Corrections::one>;
};

}}  // namespace phistep::PHISTEP_ABI
