/// @file
/// What every scheme is made of: few operations on one step's data, each counted, each guarded.
///
///     forward   next = y + γ M⁻¹Ψ(t, y), and for motion r drifted             evaluate
///     kick      next = next + γ M⁻¹Ψ(t, next), where Ψ ignores what it moves  evaluate
///     resolve   next = b on entry; M (next − b) = γ Ψ(t, next)                the implicit solve
///     carry     Ψ(t, next) = M (next − b)/γ of the last resolve, for the next step: no evaluation
///     filter    e ← (1 − γM⁻¹C − γ²M⁻¹K)⁻¹ e, with the last resolve's matrix
///
/// or, in place of resolves, linear stages (linear_stages.hpp):
///
///     linearise   Ψ, J (and Ψ_t) at (t, y)
///     factorize   M − γJ
///     solve       (M − γJ) x = b
///
/// A traced step (step/transaction/trace.hpp) also leaves its slopes in the trace: forward begins with start = y'(t), known from the
/// step before or by a force call, and resolve ends with end = (next − b)/γ, the slope at its end.
#pragma once

#include <type_traits>
#include <utility>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/kernel/algebraic_start.hpp"
#include "phistep/step/kernel/explicit_passes.hpp"
#include "phistep/step/kernel/kernel_needs.hpp"
#include "phistep/step/kernel/resolvent_of.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/transaction/trace.hpp"
#include "phistep/step/transaction/transaction.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The operations, bound to a right-hand side, a way to solve, and the transaction that a step is.
template <State S, class RightHandSideOf, class Solver, KernelNeeds needs>
class Kernel {
 public:
  using Rhs = RightHandSideOf;
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  /// One correction leaves the linearised Ψ. Carrying it would replace every later force call by a linearisation.
  static constexpr bool carries = needs.carries && !is_linearly_implicit<Solver>;
  using Transaction = phistep::Transaction<S, Rhs, carries>;
  using Data = typename Transaction::Data;
  using TracedData = typename Transaction::TracedData;
  using Passes = ExplicitPasses<S, Rhs, needs, carries>;
  using Resolvent = ResolventOf<S, Rhs, Solver, needs>;
  static_assert(needs.passes == 0 || (!needs.solver && !needs.stages));
  static_assert(needs.stages || !needs.solver || Resolves<Resolvent, S, Rhs>);

  /// @param copy  of the state
  Kernel(const S& state, const Plain& copy, Rhs rhs, const Solver& solver)
      : rhs_{std::move(rhs)}, transaction_{state, copy}, passes_{state}, resolvent_{copy, rhs_, solver} {
    passes_.bind(copy);
    transaction_.failure().is_singular = algebra_.bind(rhs_, copy);
    if constexpr (ShowsTrials<S> && !steps_in_place) state.reserve();
  }

  /// Runs `advance(Data&) → Outcome` as one step of the state. A step that fails leaves nothing behind.
  /// @param keeps_tries  … unless it ends with an outcome: the next, shorter try reuses Jacobian and factors
  StepReport run(S& state, const auto& steps, Origin origin, bool keeps_tries, auto&& advance, auto&& accepted) {
    passes_.begin_step(rhs_, state, origin, keeps_tries);
    if constexpr (needs.solver || needs.stages) {
      Unless done{*this};
      const StepReport report = transaction_.run(rhs_, state, steps, origin, advance, accepted);
      if (report) algebra_.reached(steps.t(0) + steps.dt, state);
      done.is = keeps_tries || report || !is_begun(report.outcome());
      return report;
    } else {
      const StepReport report = transaction_.run(rhs_, state, steps, origin, advance, accepted);
      passes_.end_step(static_cast<bool>(report));
      return report;
    }
  }
  /// Several steps in a call.
  static constexpr bool takes_several = Transaction::takes_several && !needs.solver && !needs.stages;
  static constexpr bool steps_in_place = Passes::steps_in_place;
  [[nodiscard]] bool can_step_in_place(const S& state) { return passes_.arrays().can(rhs_, state); }
  StepReport run_in_place(S& state, Scalar t, Scalar dt, Origin origin, auto&& advance) {
    transaction_.reset();
    return passes_.arrays().run(rhs_, transaction_, state, t, dt, origin, advance);
  }
  /// Of the last step: the sizes of its solves' corrections.
  [[nodiscard]] const Failure& history() const { return transaction_.failure(); }

  /// next = y + γ M⁻¹Ψ(t, y), r drifted
  template <class Step>
  [[nodiscard]] Outcome forward(Step& step, const Advance<Scalar>& by) {
    if constexpr (Step::is_traced) {
      if (const Outcome bad = start(step); failed(bad)) return bad;
      assign<S>(step.next, in<S>(step.y) + by.kick * in<S>(step.trace.start));
      return Outcome::success;
    } else {
      if constexpr (requires { Resolvent::looks_at_all; })
        if (by.kick != 0) {
          if (!step.psi_known) rhs_.evaluate_into(step.t, step.y, step.psi);
          step.psi_known = true;
          move_fields<S>(step.next, step.y, by, RateOf<S>::blocks(std::as_const(step.psi)), rhs_.masses());
          return Outcome::success;
        }
      if (by.kick != 0) return kick_drift(step, by);
      copy_blocks<S>(step.next, step.y);  // no weight on Ψ(t, y): it isn't evaluated
      drift_blocks<S>(step.next, by.before);
      // Positions that what follows doesn't move, and doesn't look at.
      return by.before == 0 || Rhs::is_finite(step.next) ? Outcome::success : Outcome::non_finite_state;
    }
  }
  /// The same in one pass, whether the step is traced or not: next.v = v + γ M⁻¹Ψ(t, y), next.r = r + (before v + after v⁺)
  [[nodiscard, gnu::always_inline]] inline Outcome kick_drift(Data& step, const auto& by) {
    return passes_.kick_drift(rhs_, step, by);
  }
  /// next = next + γ M⁻¹Ψ(t, next), where Ψ ignores what it moves
  [[nodiscard, gnu::always_inline]] inline Outcome kick(Data& step, Scalar gamma, Scalar t) {
    return passes_.kick(rhs_, step, gamma, t);
  }
  /// next = b on entry, the solution of M (next − b) = γ Ψ(t, next) on exit
  template <class Step>
  [[nodiscard]] Outcome resolve(Step& step, const Gamma<Scalar>& gamma, Scalar t) {
    return resolve(step, gamma, t, step.y);
  }
  /// … sought from `guess`, which must not be `next`; in a traced step from the prediction where there is one, and then from
  /// `guess` if the force doesn't exist there.
  template <class Step>
  [[nodiscard]] Outcome resolve(Step& step, const Gamma<Scalar>& gamma, Scalar t, const PlainState<S>& guess) {
    if constexpr (Step::is_traced) {
      Trace<Plain>& trace = step.trace;
      copy_blocks<S>(trace.end, step.next);  // b
      Outcome outcome = Outcome::non_finite_force;
      if (std::exchange(step.has_prediction, false)) {
        outcome = resolve_from(step, gamma, t, trace.predicted, &trace);
        if (outcome == Outcome::non_finite_force || outcome == Outcome::non_finite_state)
          copy_blocks<S>(step.next, trace.end);
      }
      if (outcome == Outcome::non_finite_force || outcome == Outcome::non_finite_state)
        outcome = resolve_from(step, gamma, t, guess, &trace);
      if (failed(outcome)) return outcome;
      assign_solved<S>(trace.end, (in<S>(step.next) - in<S>(trace.end)) / gamma.force);
      if constexpr (Rhs::drifts) position_of<S>(trace.end) = velocity_of<S>(step.next);
      return outcome;
    } else {
      return resolve_from(step, gamma, t, guess, nullptr);
    }
  }
  /// trace.start = y' at (t, y): no force call where the step before has left it.
  [[nodiscard]] Outcome start(TracedData& step) {
    Trace<Plain>& trace = step.trace;
    if (trace.knows_start) return Outcome::success;
    if (!rhs_.slope(step.t, step.y, trace.start, step.psi)) {
      copy_blocks<S>(step.next, step.y);  // kept for the failure message
      return Outcome::non_finite_force;
    }
    trace.knows_start = true;
    algebra_.start_by_force();
    return Outcome::success;
  }
  /// Of a singular M, a start that does not satisfy the algebraic equations is refused (algebraic_start.hpp): once, with W for
  /// the step's first γ.
  template <class Step>
  [[nodiscard]] Outcome check_start(Step& step, const Gamma<Scalar>& gamma) {
    if constexpr (Rhs::may_be_singular) {
      if (!algebra_.is_due(step.t, step.dt, step.y)) return Outcome::success;
      if constexpr (!needs.stages || needs.shifted) {
        if (!step.psi_known) rhs_.evaluate_into(step.t, step.y, step.psi);
        step.psi_known = true;
      }
      copy_blocks<S>(step.next, step.y);  // kept for the failure message
      const Outcome outcome = algebra_.check(
          rhs_, step, [&](const auto& residual, Plain& response) { return respond(step, gamma, residual, response); });
      if (outcome == Outcome::inconsistent_start) transaction_.accuse(algebra_.worst());
      return outcome;
    }
    return Outcome::success;
  }
  /// Completes trace.start where it is M⁻¹Ψ of a singular M.
  void complete_start(TracedData& step) { algebra_.complete_start(rhs_, step); }
  /// trace.end = y' at (t + Δt, next), by a force call
  [[nodiscard]] Outcome end(TracedData& step) {
    if (!Rhs::is_finite(step.next)) return Outcome::non_finite_state;
    const bool finite = rhs_.slope(step.t + step.dt, step.next, step.trace.end, step.psi);
    return finite ? Outcome::success : Outcome::non_finite_force;
  }
  /// Leaves Ψ(t + Δt, next), as the last resolve knows it, to the next step; a traced step has left it in the trace.
  template <class Step>
  void carry(Step& step, const Gamma<Scalar>& gamma) {
    if constexpr (carries && !Step::is_traced) {
      // Where the last resolve solved nothing, psi holds Ψ already.
      if (Rhs::couples_unknowns || gamma.drift != 0)
        recover_force<S>(rhs_, resolvent_.increment(), gamma.force, step.psi);
      step.psi_next_known = true;
    }
  }
  /// psi = Ψ(t, y); what is not finite in it shows in the step.
  void evaluate(Scalar t, const Plain& y, RateOf<S>& psi) { rhs_.evaluate_into(t, y, psi); }
  /// step.psi = Ψ(t, y), with J and, where has_time, Ψ_t there
  template <class Step>
  [[nodiscard]] Outcome linearise(Step& step) requires(needs.stages) {
    const Outcome outcome = resolvent_.linearise(rhs_, step.t, step.dt, step.y, step.psi, allowed(step));
    step.psi_known = outcome == Outcome::success;
    if (outcome == Outcome::non_finite_force) copy_blocks<S>(step.next, step.y);  // kept for the failure message
    return outcome;
  }
  static constexpr bool has_time = !Rhs::is_autonomous;
  [[nodiscard]] const auto& psi_t() const requires(needs.stages&& has_time) { return resolvent_.psi_t(); }
  /// M − γJ of the last linearisation, factorized
  [[nodiscard]] Outcome factorize(Scalar gamma) requires(needs.stages) { return resolvent_.factorize(rhs_, gamma); }
  /// (M − γJ) x = b, in place, for all blocks
  [[nodiscard]] Outcome solve(Scalar gamma, Plain& x) requires(needs.stages) {
    return resolvent_.solve(rhs_, gamma, x);
  }
  /// to.solved += factor M x
  void add_mass_product(Plain& to, Scalar factor, const Plain& x) const {
    for_each_block(
        [factor](auto, auto& out, const auto& of, const auto& mass) {
          if constexpr (FieldState<S>) out += (factor * static_cast<Scalar>(mass[0])) * of;
          else mass.add_product([&](Index i) { return factor * of.data()[i]; }, out);
        },
        Blocks<S>::solved(to), Blocks<S>::solved(x), rhs_.masses());
  }
  /// The linear stages themselves, for schemes that want more of them.
  [[nodiscard]] auto& stages() requires(needs.stages) { return resolvent_; }
  /// Takes out of an error estimate what the scheme damps anyway (L. F. Shampine, ACM Trans. Math. Softw. 10 (1984) 291):
  /// without it, stiff components that are long at rest would rule Δt. Solved blocks only: r is not stiff.
  [[nodiscard]] Outcome filter(Plain& error) {
    if constexpr (needs.solver) return resolvent_.filter(rhs_, error);
    else return Outcome::success;
  }
  /// next.solved += factor·(next − b) of the last resolve
  void add_increment(Data& step, Scalar factor) const { add_unknowns<S>(step.next, factor, resolvent_.increment()); }

  /// How well a solve has to be done; empty: as the solver's options say.
  template <class Step>
  [[nodiscard]] static SolveTolerance<Plain> allowed(const Step& step) {
    if constexpr (Step::is_traced) return allowed_by(&step.trace);
    else return {};
  }
  [[nodiscard]] bool keeps_factors() const {
    if constexpr (needs.stages) return true;
    else if constexpr (needs.solver) return resolvent_.keeps_factors();
    else return false;
  }
  [[nodiscard]] const char* solver_name() const {
    if constexpr (needs.solver || needs.stages) return resolvent_.solver_name();
    else return "none";
  }
  [[nodiscard]] Rhs& rhs() { return rhs_; }
  [[nodiscard]] const Rhs& rhs() const { return rhs_; }
  [[nodiscard]] bool fits(const S& state) const { return !torn_ && transaction_.fits(state); }
  /// Forgets all that is carried from step to step.
  void reset() {
    forget_force();
    resolvent_.reset();
    algebra_.forget();
  }
  /// Forgets what solves have left, and nothing else.
  void forget_solves() { resolvent_.forget(); }
  /// Forgets Ψ alone.
  void forget_force() {
    transaction_.reset();
    passes_.forget();
    if constexpr (needs.stages) resolvent_.forget_force();
  }
  void resize(const S& state, const PlainState<S>& copy, typename Rhs::Masses masses) {
    Transaction fresh{state, copy};
    torn_ = true;  // if one of these throws, not even a state of the old size fits
    resolvent_.resize(copy, rhs_);
    rhs_.rebind(std::move(masses));
    transaction_ = std::move(fresh);
    passes_.forget();
    passes_.bind(copy);
    transaction_.failure().is_singular = algebra_.bind(rhs_, copy);
    torn_ = false;
  }
  static constexpr bool has_unsaved = FieldState<S> || requires(Resolvent & resolvent) { resolvent.forget_unsaved(); };
  /// Forgets what a checkpoint leaves out: Jacobian, factors, patterns, and what solves have learnt.
  void forget_unsaved() requires(has_unsaved) {
    // That Ψ is known is a matter of this vector, not of its numbers.
    if constexpr (FieldState<S>) transaction_.reset();
    if constexpr (requires { resolvent_.forget_unsaved(); }) resolvent_.forget_unsaved();
    algebra_.forget();
  }

  /// For a checkpoint: history, counts, Ψ.
  void archive(auto& ar) {
    ar.fact("state", transaction_.shape());
    if constexpr (carries) ar("psi", transaction_);
    ar("force", rhs_);
    ar.at_last([this] {
      passes_.forget();
      if constexpr (has_unsaved) forget_unsaved();
    });
  }

 private:
  /// What ends otherwise than well, by an exception as well, is forgotten.
  struct Unless {
    Kernel& kernel;
    bool is = false;
    ~Unless() {
      if (!is) kernel.forget_solves();
    }
  };
  /// A step that was refused for its arguments wasn't.
  [[nodiscard]] static constexpr bool is_begun(Outcome outcome) {
    return outcome != Outcome::invalid_step && outcome != Outcome::step_too_small;
  }

  /// response = W⁻¹ γ residual
  [[nodiscard]] Outcome respond(const auto& step, const Gamma<Scalar>& gamma, const auto& residual, Plain& response) {
    set_zero(Blocks<S>::all(response));
    if constexpr (needs.stages) {
      assign_solved<S>(response, gamma.force * in_rate<S>(residual));
      return resolvent_.solve(rhs_, gamma.force, response);
    } else if constexpr (requires { typename Resolvent::Matrix; }) {
      return resolvent_.respond(rhs_, gamma, step.t, step.y, step.psi, residual, response, allowed(step));
    } else {
      return Outcome::success;  // particle by particle: Newton will find out
    }
  }

  [[nodiscard, gnu::always_inline]] inline Outcome resolve_from(Data& step, const Gamma<Scalar>& gamma, Scalar t,
                                                                const PlainState<S>& guess, const Trace<Plain>* trace) {
    if constexpr (!Rhs::couples_unknowns)
      if (gamma.drift == 0) return kick(step, gamma.force, t);
    if constexpr (needs.solver) {
      // Where the iteration starts from y itself, its first Ψ may be there already.
      bool psi_known = step.psi_known && Rhs::is_autonomous && !Rhs::drifts && &guess == &step.y;
      if constexpr (requires { resolvent_.wants_differences(); })
        psi_known = psi_known && !(step.psi_carried && resolvent_.wants_differences());
      step.psi_known = false;
      const Outcome outcome = resolvent_.resolve(rhs_, gamma, t, step.next, guess, step.psi, transaction_.failure(),
                                                 psi_known, allowed_by(trace));
      if constexpr (requires { Resolvent::looks_at_all; }) return outcome;
      if (failed(outcome)) return outcome;
      return rhs_.is_finite(step.next) ? Outcome::success : Outcome::non_finite_state;
    }
    return Outcome::success;
  }
  [[nodiscard]] static SolveTolerance<Plain> allowed_by(const Trace<Plain>* trace) {
    if (trace == nullptr) return {};
    return {&trace->weight, trace->newton_target, trace->rtol, trace->usual, trace->has_unsized};
  }

  Rhs rhs_;
  Transaction transaction_;
  [[no_unique_address]] Passes passes_;
  [[no_unique_address]] Resolvent resolvent_;
  [[no_unique_address]] std::conditional_t<Rhs::may_be_singular, AlgebraicStart<S, Rhs>, RegularStart> algebra_;
  bool torn_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
