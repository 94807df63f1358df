/// @file
/// What outlives a step: the right-hand side, a way to solve, the transaction that a step is, and what these have learnt. During a
/// step an equation (equation.hpp) stands before it.
#pragma once

#include <type_traits>
#include <utility>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/kernel/algebraic_start.hpp"
#include "phistep/step/kernel/equation.hpp"
#include "phistep/step/kernel/explicit_passes.hpp"
#include "phistep/step/kernel/falling_rates.hpp"
#include "phistep/step/kernel/traced_equation.hpp"
#include "phistep/step/solve/linear_stages.hpp"
#include "phistep/step/solve/resolvent.hpp"
#include "phistep/step/transaction/trace.hpp"
#include "phistep/step/transaction/transaction.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// What solves a scheme's implicit equations, by the scheme's needs and the user's solver.

/// An explicit scheme solves nothing.
struct NoResolvent : ResolventDefaults {
  explicit NoResolvent(const auto&...) {}
  static void resize(const auto&, const auto&) {}
  [[nodiscard]] static const char* solver_name() { return "none"; }
};

/// What linear stages are solved with. Shifted ones come with the schemes that have them (schemes/radau/shifted_stages.hpp).
template <State S, class Rhs, class LinearSolver, bool shifted>
struct StagesFor;
template <State S, class Rhs, class LinearSolver>
struct StagesFor<S, Rhs, LinearSolver, false> {
  using type = LinearStages<S, Rhs, LinearSolver>;
};

template <State S, class Rhs, class Solver, KernelNeeds needs>
[[nodiscard]] constexpr auto resolvent_type() {
  constexpr bool is_linear = requires { typename Solver::LinearSolver; };
  static_assert(!needs.stages || is_linear,
                "phistep: this scheme solves linear equations and iterates nothing: give it newton<LinearSolver>() or "
                "newton<MatrixFree<>>(), not fixed_point()");
  if constexpr (needs.stages && is_linear) return StagesFor<S, Rhs, typename Solver::LinearSolver, needs.shifted>{};
  else if constexpr (needs.stages) return StagesFor<S, Rhs, void, needs.shifted>{};
  else if constexpr (needs.solver) return ResolventFor<S, Rhs, Solver, needs.position>{};
  else return std::type_identity<NoResolvent>{};
}
template <State S, class Rhs, class Solver, KernelNeeds needs>
using ResolventOf = typename decltype(resolvent_type<S, Rhs, Solver, needs>())::type;

template <State S, class RightHandSideOf, class Solver, KernelNeeds needs_of>
class Kernel {
 public:
  using StateType = S;
  using Rhs = RightHandSideOf;
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  static constexpr KernelNeeds needs = needs_of;
  /// One correction leaves the linearized Ψ. Carrying it would replace every later force call by a linearization.
  static constexpr bool carries = needs.carries && !is_linearly_implicit<Solver>;
  using Transaction = phistep::Transaction<S, Rhs, carries>;
  using Equation = phistep::Equation<Kernel>;
  using Traced = TracedEquation<Equation>;
  using Passes = ExplicitPasses<S, Rhs, needs, carries>;
  using Resolvent = ResolventOf<S, Rhs, Solver, needs>;
  static constexpr bool may_see_falling_rates =
      !FieldState<S> && !Rhs::Traits::is_affine && Resolvent::solves_by_factors;
  static_assert(needs.passes == 0 || (!needs.solver && !needs.stages));
  static_assert(needs.stages || !needs.solver || Resolves<Resolvent, S, Rhs>);

  /// @param copy  of the state
  Kernel(const S& state, const Plain& copy, Rhs rhs, const Solver& solver)
      : rhs_{std::move(rhs)}, transaction_{state, copy}, passes_{state}, resolvent_{copy, rhs_, solver} {
    passes_.bind(copy);
    transaction_.record().is_singular = algebraic_start_.bind(rhs_, copy);
    if constexpr (ShowsTrials<S> && !steps_in_place) state.reserve();
  }

  /// Takes `advance(Equation&) → Outcome` as one step of the state, or several. A step that fails leaves nothing behind.
  StepReport take(S& state, const auto& steps, Origin origin, auto&& advance, auto&& accepted) {
    const auto equation_of = [this](auto&... where) { return Equation{*this, where...}; };
    return transact(state, steps, origin, false, equation_of, advance, accepted);
  }
  /// Takes `advance(TracedEquation&) → Outcome` as one step. Where it ends with an outcome, the next, shorter try reuses Jacobian and
  /// factors.
  StepReport take_traced(S& state, const auto& step, Origin origin, Trace<Plain>& trace, const Judge<Plain>& judge,
                         auto&& advance, auto&& accepted) {
    const auto equation_of = [&](auto&... where) { return Traced{Equation{*this, where...}, trace, judge}; };
    return transact(state, step, origin, true, equation_of, advance, accepted);
  }
  /// Several steps in a call.
  static constexpr bool takes_several = Transaction::takes_several && !needs.solver && !needs.stages;
  static constexpr bool steps_in_place = Passes::steps_in_place;
  [[nodiscard]] bool can_step_in_place(const S& state) { return passes_.arrays().can(rhs_, state); }
  StepReport take_in_place(S& state, Scalar t, Scalar dt, Origin origin, auto&& advance) {
    transaction_.reset();
    return passes_.arrays().take(rhs_, transaction_, state, t, dt, origin, advance);
  }
  /// The sizes of the corrections in the solves of the last step.
  [[nodiscard]] const SolveRecord& last_solve() const { return transaction_.record(); }
  [[nodiscard]] bool keeps_factors() const {
    if constexpr (needs.stages) return true;
    else return resolvent_.keeps_factors();
  }
  [[nodiscard]] const char* solver_name() const { return resolvent_.solver_name(); }
  [[nodiscard]] Rhs& rhs() { return rhs_; }
  [[nodiscard]] const Rhs& rhs() const { return rhs_; }
  [[nodiscard]] Passes& passes() { return passes_; }
  [[nodiscard]] Resolvent& resolvent() { return resolvent_; }
  [[nodiscard]] auto& algebraic_start() { return algebraic_start_; }
  [[nodiscard]] auto& falling_rates() requires may_see_falling_rates { return falling_rates_; }
  [[nodiscard]] Transaction& transaction() { return transaction_; }
  [[nodiscard]] bool fits(const S& state) const { return !torn_ && transaction_.fits(state); }
  /// Forgets all that is carried from step to step.
  void reset() {
    forget_force();
    resolvent_.reset();
    algebraic_start_.forget();
  }
  /// Forgets what solves have left, and nothing else.
  void forget_solves() { resolvent_.forget(); }
  /// Forgets Ψ alone. @param stays  the state is known to be as it was: another active set is the reason
  void forget_force(bool stays = false) {
    transaction_.reset();
    passes_.forget(stays);
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
    transaction_.record().is_singular = algebraic_start_.bind(rhs_, copy);
    torn_ = false;
  }
  static constexpr bool has_unsaved = FieldState<S> || requires(Resolvent & resolvent) { resolvent.forget_unsaved(); };
  /// Forgets what a checkpoint leaves out: Jacobian, factors, patterns, and what solves have learnt.
  void forget_unsaved() requires(has_unsaved) {
    // A field's Ψ is known by the vector itself, not by its numbers.
    if constexpr (FieldState<S>) transaction_.reset();
    if constexpr (requires { resolvent_.forget_unsaved(); }) resolvent_.forget_unsaved();
    algebraic_start_.forget();
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
  /// @param keeps_tries  a step that ends with an outcome leaves what its solves have made
  StepReport transact(S& state, const auto& steps, Origin origin, bool keeps_tries, auto& equation_of, auto& advance,
                      auto& accepted) {
    passes_.begin_step(rhs_, state, origin, keeps_tries);
    if constexpr (needs.solver || needs.stages) {
      bool keeps_solves = false;  // unless the step succeeds, what solves have made is dropped, also on an exception
      const AtExit forget{[&] {
        if (!keeps_solves) forget_solves();
      }};
      const StepReport report = transaction_.take(rhs_, state, steps, origin, equation_of, advance, accepted);
      if (report) algebraic_start_.reached(steps.t(0) + steps.dt, state);
      const Outcome outcome = report.outcome();  // for its arguments a step is refused before anything is computed
      keeps_solves = keeps_tries || report || outcome == Outcome::invalid_step || outcome == Outcome::step_too_small;
      return report;
    } else {
      const StepReport report = transaction_.take(rhs_, state, steps, origin, equation_of, advance, accepted);
      passes_.end_step(static_cast<bool>(report));
      return report;
    }
  }

  Rhs rhs_;
  Transaction transaction_;
  [[no_unique_address]] Passes passes_;
  [[no_unique_address]] Resolvent resolvent_;
  [[no_unique_address]] std::conditional_t<Rhs::may_be_singular, AlgebraicStart<S, Rhs>, RegularStart> algebraic_start_;
  [[no_unique_address]] Only<may_see_falling_rates, FallingRates<S>> falling_rates_;
  bool torn_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
