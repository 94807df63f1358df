/// @file
/// PhiStepper: the φ-method, and every other scheme, for a state under a force.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/only.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/at.hpp"
#include "phistep/linear/network/network_system.hpp"
#include "phistep/run/control/fixed_step.hpp"
#include "phistep/run/errors/automatic_atol.hpp"
#include "phistep/schemes/respa.hpp"
#include "phistep/schemes/splitting.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/kernel/kernel.hpp"
#include "phistep/step/kernel/scheme_on.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/mass/mass.hpp"
#include "phistep/step/solve/fixed_point_resolvent.hpp"
#include "phistep/step/transaction/transaction.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Steps a state S under a force F by the φ-method, or by any other scheme.
/// @tparam MassSpec  what mass(…) or capacity(…) returned, UnitMasses for M = 1
/// @tparam Solver    how the implicit equations are solved
template <class S, class F, class Scheme, class MassSpec = UnitMasses, ImplicitSolver Solver = Newton<>>
class PhiStepper {
  using Masses = decltype(bind_masses<S>(std::declval<const MassSpec&>(), std::declval<const PlainState<S>&>()));
  static constexpr bool split = is_split<Unwrapped<F>, Scheme>;
  using Rhs = RightHandSide<S, F, Masses, split>;
  using Traits = typename Rhs::Traits;
  using Alone = SchemeOn<Scheme, S>;
  static auto working_type() {
    if constexpr (Rhs::has_inner_steps && slow_halves<Scheme> >= 0)
      return std::type_identity<RespaScheme<Alone, S, Rhs, slow_halves<Scheme>>>{};
    else if constexpr (split) return std::type_identity<SplitScheme<Alone, S, Rhs>>{};
    else return std::type_identity<Alone>{};
  }
  using Working = typename decltype(working_type())::type;
  static constexpr KernelNeeds needs = [] {
    if constexpr (Traits::valid) return Working::template needs<Rhs>;
    else return KernelNeeds{};
  }();
  using Kernel = phistep::Kernel<S, Rhs, Solver, needs>;

 public:
  using Scalar = ScalarOf<S>;
  using StateType = S;
  using SchemeType = Scheme;
  using ArchivedByParts = void;
  static constexpr const char* part_name = "stepper";
  /// What a repetition of the run from here needs to know beside the state.
  struct Checkpoint {
    typename Rhs::Memory memory;
    typename Working::Progress progress;
  };

  static_assert(Refusal<Traits::fault, Rhs::drifts>::is_said);
  static_assert(
      !Traits::valid || StepsOn<Working, S, Kernel>,
      "phistep: this scheme's SchemeOn lacks what the concept StepsOn (phistep/step/kernel/scheme_on.hpp) asks for");
  static_assert(
      suits<Unwrapped<F>, Scheme>,
      "phistep: at(scheme, term) takes forward_euler or the stepper's own scheme (terms at other phi: not yet)");
  static_assert(RespaRefusal<Unwrapped<F>, Scheme>::is_said);
  static_assert(!is_at<F>, "phistep: at(scheme, term) marks a term of a sum, there is no sum here");
  static_assert(
      !Scheme::facts.motion_only || Rhs::drifts,
      "phistep: a pair (phi_force, phi_drift) and velocity_verlet need a motion (r, v), not a first-order state");

  /// @param state   gives the sizes; it is not kept
  /// @param psi     the force Ψ, copied; wrap it in std::ref to keep it outside
  /// @param scheme  forward_euler, trapezoidal, backward_euler, midpoint, velocity_verlet, phi(0.7), tr_bdf2, …
  /// @param mass    mass(m) or capacity(C); M = 1 if left out
  /// @param solver  newton(options) or newton<LinearSolver>(options)
  /// @throws std::invalid_argument where sizes or masses can't work
  PhiStepper(const S& state, F psi, Scheme scheme, MassSpec mass = {}, Solver solver = {})
      : PhiStepper{Kernel::Transaction::copy_of(state), state, std::move(psi), scheme, std::move(mass), solver} {}
  PhiStepper(const S& state, F psi, Scheme scheme, Solver solver) requires std::is_same_v<MassSpec, UnitMasses>
      : PhiStepper{state, std::move(psi), scheme, UnitMasses{}, solver} {}

  /// Advances the state from t to t + dt. [time] dt < 0 steps backward.
  /// On any failure the state keeps every bit; an exception thrown by the force passes through, likewise. The next step is
  /// then that of a new stepper with the same history.
  StepReport step(S& state, Scalar t, Scalar dt) { return step(state, t, dt, Origin::unknown); }

  /// Origin::unedited: the state is what the last step left; saves the check for edits.
  StepReport step(S& state, Scalar t, Scalar dt, Origin origin) { return steps(state, OneStep<Scalar>{t, dt}, origin); }

  /// Several steps can be done in one call: nothing is lost that their state need not be looked at in between.
  static constexpr bool takes_several = Kernel::takes_several && !Rhs::has_inner_steps;
  /// One step, or some where takes_several, each from where the one before ends. What statistics() count as steps are done.
  template <class Steps>
  StepReport steps(S& state, const Steps& all, Origin origin) {
    if constexpr (Traits::valid) {
      if constexpr (static_unknowns<S> == Eigen::Dynamic)
        if (!kernel_.fits(state)) resize(state);
      return run(state, all, origin);
    } else {
      return {};
    }
  }

  /// Some terms are called once in several inner steps (force/seldom.hpp).
  static constexpr bool has_inner_steps = Working::has_inner_steps;
  static constexpr StepperFacts facts{.traces = Working::traces,
                                      .interpolates = Working::interpolates,
                                      .is_sure_inside = Working::is_sure_inside,
                                      .solves_nothing = !needs.solver && !needs.stages && !has_inner_steps,
                                      .reads_weights = needs.solver || needs.stages || Working::reads_weights,
                                      .refactorizes = needs.stages && !Traits::is_affine,
                                      .is_affine = Traits::is_affine,
                                      .doubtful_at = Working::doubtful_at};
  /// Whether `attempt` can say how large this step's error is: some schemes always, some once they have a past, some never
  /// (StepDoubling serves those).
  [[nodiscard]] bool estimates(const Trace<PlainState<S>>& trace) const {
    if constexpr (facts.traces) return working_.estimates(trace);
    else return false;
  }
  /// A step that becomes the state only if accept(y, y⁺, trace) says so; otherwise Outcome::error_too_large, and the state
  /// keeps every bit. The trace tells of the step what it can. What a failed try has found serves the next; after the last try
  /// call forget_solves().
  /// @param accept  a judge (step/kernel/traced_equation.hpp)
  template <class Accept>
  StepReport attempt(S& state, Scalar t, Scalar dt, Origin origin, Trace<PlainState<S>>& trace,
                     const Accept& accept) requires(facts.traces.value) {
    if constexpr (Traits::valid) {
      if constexpr (static_unknowns<S> == Eigen::Dynamic)
        if (!kernel_.fits(state)) resize(state);
      const auto advance = [&](auto& eq) {
        Outcome outcome = take_step(working_, eq);
        if (!failed(outcome)) outcome = working_.error(eq);
        if (failed(outcome)) return outcome;
        if (!accept(eq.y, std::as_const(eq.next), trace)) return Outcome::error_too_large;
        return working_.reach_end(eq);
      };
      return kernel_.run_traced(state, OneStep<Scalar>{t, dt}, origin, trace, accept, advance,
                                [this] { working_.accepted(); });
    } else {
      return {};
    }
  }
  /// out = y' at (t, y): for motion v and M⁻¹Ψ. One force call; false where it isn't finite.
  [[nodiscard]] bool slope(Scalar t, const PlainState<S>& y, PlainState<S>& out) {
    if (!slope_psi_) slope_psi_.emplace();
    reset_rate<S>(*slope_psi_, y);
    return kernel_.rhs().whole_slope(t, y, out, *slope_psi_);
  }
  /// Makes the Jacobian at (t, y) ready, of a scheme with linear stages: the first step finds it if it starts there.
  /// @param dt  [time] over which the force is looked at where it uses time
  [[nodiscard]] Outcome linearise(Scalar t, Scalar dt, const PlainState<S>& y,
                                  const SolveTolerance<PlainState<S>>& allowed) requires(needs.stages) {
    if (!slope_psi_) slope_psi_.emplace();
    reset_rate<S>(*slope_psi_, y);
    kernel_.rhs().begin(t, dt, y);
    return kernel_.resolvent().linearise(kernel_.rhs(), t, dt, y, *slope_psi_, false, allowed);
  }
  /// The pattern of its W, and f(slot, K, C) for each entry's tangents, once there is a Jacobian.
  [[nodiscard]] const auto& tangents(const PlainState<S>& y) requires(needs.stages) {
    auto& system = kernel_.resolvent().matrix().system();
    static_cast<void>(system.settle(each_mass_entry<S>(kernel_.rhs().masses(), y)));
    return system;
  }
  /// What the force of a field, or its solver, has thrown on this rank.
  [[nodiscard]] HeldException& held() requires FieldState<PlainState<S>> { return *kernel_.rhs().held(); }
  /// M is singular: some of the equations are algebraic.
  [[nodiscard]] bool solves_algebraic() const {
    if constexpr (Rhs::may_be_singular) return static_cast<bool>(algebraic_component(masses()));
    else return false;
  }
  /// rate = the part of Ψ(t, y) outside the range of M. One force call; false where Ψ isn't finite.
  [[nodiscard]] bool algebraic_residual(Scalar t, const PlainState<S>& y, RateOf<S>& rate) {
    kernel_.rhs().begin(t, Scalar{0}, y);
    kernel_.rhs().evaluate_into(t, y, rate);
    const bool finite = !first_non_finite(RateOf<S>::blocks(rate));
    if (finite) phistep::keep_unexplained(RateOf<S>::blocks(rate), masses());
    return finite;
  }
  /// x ← what M doesn't see of it
  void keep_unseen(PlainState<S>& x) const { phistep::keep_unseen(Blocks<S>::solved(x), masses()); }
  /// To slopes by force calls at both ends of a step: what M doesn't see moves from y0 to y1 along the chord.
  void complete_slopes(const PlainState<S>& y0, const PlainState<S>& y1, Scalar dt, PlainState<S>& slope0,
                       PlainState<S>& slope1) const {
    if constexpr (Rhs::may_be_singular)
      if (solves_algebraic()) {
        PlainState<S> chord = y0;
        assign<S>(chord, (in<S>(y1) - in<S>(y0)) / dt);
        keep_unseen(chord);
        add<S>(slope0, in<S>(chord));
        add<S>(slope1, in<S>(chord));
      }
  }
  /// Of the last step: the sizes of its solves' corrections.
  [[nodiscard]] const SolveRecord& last_solve() const { return kernel_.last_solve(); }

  [[nodiscard]] int order() const { return working_.order(); }
  /// The power of Δt with which the error estimate of `attempt` goes.
  [[nodiscard]] int error_order() const {
    if constexpr (requires { working_.error_order(); }) return working_.error_order();
    else return working_.order() + 1;
  }
  /// Calls the force where `interpolate` needs more of the step from y0 that `attempt` did last with trace.wants_dense. False
  /// where it isn't finite there: then nothing better than the ends is known inside.
  [[nodiscard]] bool know_inside([[maybe_unused]] Scalar dt, [[maybe_unused]] const PlainState<S>& y0) {
    if constexpr (requires { working_.know_inside(kernel_.rhs(), dt, y0); })
      return working_.know_inside(kernel_.rhs(), dt, y0);
    else return true;
  }
  /// out = y(t + x dt), 0 < x < 1, of the step from y0 to y1 that `know_inside` was asked about.
  void interpolate(Scalar x, Scalar dt, const PlainState<S>& y0, const PlainState<S>& y1, PlainState<S>& out) const
      requires(facts.interpolates.value) {
    working_.interpolate(x, dt, y0, y1, out);
  }
  [[nodiscard]] const Statistics& statistics() const { return kernel_.rhs().statistics(); }
  /// Of a sum: how often each term was evaluated, in their order.
  [[nodiscard]] auto calls_by_term() const requires is_sum<Unwrapped<F>> {
    using Sum = Unwrapped<F>;
    std::array<std::int64_t, std::tuple_size_v<decltype(Sum::terms)>> calls;
    calls.fill(statistics().force_calls);
    if constexpr (split) {
      constexpr auto kicks = Parts<Sum>::template places<true>;
      for (std::size_t j = 0; j < kicks.size(); ++j) {
        if constexpr (has_inner_steps) calls[kicks[j]] = working_.calls(j);
        else calls[kicks[j]] = statistics().kick_calls;
      }
    }
    return calls;
  }
  /// How the library solves the linear equations of this scheme, force and mass; "none" where there are none.
  [[nodiscard]] const char* solver_name() const { return kernel_.solver_name(); }
  /// Whether a constant Δt spares factorizations.
  [[nodiscard]] bool keeps_factors() const { return kernel_.keeps_factors(); }
  /// The scheme at work: stage values of the last step, where it has some.
  [[nodiscard]] const Working& working() const { return working_; }

  /// Who is computed from now on (base/state/active_set.hpp); null: all. The force stays the same: slopes kept elsewhere hold.
  void set_active(std::shared_ptr<const ActiveSet> active) requires Rhs::takes_active {
    active_ = std::move(active);
    follow_active();
  }
  /// M of the solved blocks, one bound mass each.
  [[nodiscard]] const Masses& masses() const { return kernel_.rhs().masses(); }

  [[nodiscard]] const Scheme& scheme() const { return scheme_; }
  [[nodiscard]] const MassSpec& mass() const { return mass_; }
  /// The force, to be called and not to be changed: nothing is forgotten.
  [[nodiscard]] auto& force_to_look_at() { return kernel_.rhs().whole_force(); }
  /// The force, to change its parameters between steps; what was known of the old one is forgotten.
  [[nodiscard]] auto& force() {
    forget();
    return kernel_.rhs().whole_force();
  }
  /// The committed history of a force with memory.
  [[nodiscard]] const auto& memory() const { return kernel_.rhs().memory(); }
  void set_memory(typename Rhs::Memory memory) {
    kernel_.rhs().set_memory(std::move(memory));
    forget();
  }
  [[nodiscard]] Checkpoint checkpoint() const { return {memory(), working_.progress()}; }
  /// Matrices stay: what they are worth shows in the next solve.
  void restore(Checkpoint checkpoint) {
    kernel_.rhs().set_memory(std::move(checkpoint.memory));
    kernel_.forget_force();
    working_.forget();
    working_.resume(checkpoint.progress);
  }
  /// For a checkpoint: what later steps depend on beside the state and the parameters given here, that is the history, how far the
  /// scheme has come, Ψ where it is carried from step to step, and the counts. A stepper made alike that has read it goes on with
  /// the bits that this one gives after forget_unsaved().
  void archive(auto& ar) {
    ar.fact("scheme", type_of_scheme());
    ar("progress", working_, "sizes", sizes_);
    kernel_.archive(ar);
  }
  /// Forgets what a checkpoint leaves out, Jacobians, factors and their patterns: save_checkpoint calls it once all is written.
  void forget_unsaved() requires(Kernel::has_unsaved) { kernel_.forget_unsaved(); }
  /// Forgets what solves have left, Jacobians and factors, as a step that fails does.
  void forget_solves() { kernel_.forget_solves(); }
  /// Starts anew: forgets all that is carried from step to step (Ψ, Jacobian, factors), and that there were steps.
  /// Never needed after an edit of the state.
  void reset() {
    forget();
    working_.reset();
    if constexpr (!FieldState<S>) sizes_.forget();
  }
  /// What runs under a tolerance without atol leave for the next.
  [[nodiscard]] auto& kept_sizes() requires(!FieldState<S>) { return sizes_; }

  /// Counts requests to forget: slopes of this force kept elsewhere are stale where it has changed.
  [[nodiscard]] std::int64_t changes() const { return changes_; }

 private:
  PhiStepper(const PlainState<S>& copy, const S& state, F&& psi, Scheme scheme, MassSpec&& mass, Solver solver)
      : scheme_{scheme},
        mass_{std::move(mass)},
        kernel_{state, copy, Rhs{std::move(psi), bind_masses<S>(mass_, copy)}, solver},
        working_{scheme, copy} {
    check_masses();
  }
  /// @throws std::invalid_argument where a mass of motion isn't positive, or M is singular and the scheme or its solver needs M⁻¹
  void check_masses() const {
    if constexpr (Rhs::drifts) {
      refuse_masses_of_motion(masses());
    } else if constexpr (Rhs::may_be_singular) {
      bool takes_singular = false;
      if constexpr (
          requires { typename Solver::LinearSolver; } && requires { working_.takes_singular_mass(); })
        takes_singular = working_.takes_singular_mass();
      if (!takes_singular) refuse_singular_masses(masses(), type_of_scheme());
    }
  }
  /// Everything inlined, the force as well: only so do the compilers keep a small state in registers from step to step.
  [[gnu::flatten]] StepReport run_inlined(S& state, const auto& all, Origin origin) {
    return kernel_.run(
        state, all, origin, [this](auto& eq) { return take_step(working_, eq); }, [this] { working_.accepted(); });
  }
  StepReport run(S& state, const auto& all, Origin origin) {
    if constexpr (Kernel::Transaction::in_registers && needs.passes > 0 && takes_several)
      return run_inlined(state, all, origin);
    const auto accepted = [this] { working_.accepted(); };
    if constexpr (Kernel::steps_in_place)
      if (kernel_.can_step_in_place(state)) {
        const StepReport report =
            kernel_.run_in_place(state, all.t(0), all.dt, origin, [this](auto& eq) { return working_.step(eq); });
        if (report) accepted();
        return report;
      }
    return kernel_.run(
        state, all, origin, [this](auto& eq) PHISTEP_DETAIL_INLINED { return take_step(working_, eq); }, accepted);
  }
  /// Without parameters, which are the program's.
  [[nodiscard]] static std::string type_of_scheme() {
    if constexpr (requires { Scheme::name(); }) return Scheme::name();
    else return "a scheme of the user's own";
  }
  void forget() {
    ++changes_;
    kernel_.reset();
    working_.forget();
  }
  void resize(const S& state) {
    // What may throw comes first: a stepper half resized would write out of bounds at the next step.
    const auto copy = Kernel::Transaction::copy_of(state);
    auto masses = bind_masses<S>(mass_, copy);
    Working fresh = working_;
    fresh.resize(copy);
    kernel_.resize(state, copy, std::move(masses));
    working_ = std::move(fresh);
    if constexpr (Rhs::takes_active) follow_active();
    check_masses();
  }
  void follow_active() {
    kernel_.forget_solves();
    if (!kernel_.rhs().set_active(active_)) return;
    kernel_.forget_force();
    working_.forget();
  }

  [[no_unique_address]] Scheme scheme_;
  [[no_unique_address]] MassSpec mass_;
  Kernel kernel_;
  [[no_unique_address]] Only<Rhs::takes_active, std::shared_ptr<const ActiveSet>> active_;
  [[no_unique_address]] Working working_;
  std::optional<RateOf<S>> slope_psi_;  // scratch, kept for the next slope
  std::int64_t changes_ = 0;
  [[no_unique_address]] Only<!FieldState<S>, KeptSizes<PlainState<S>>> sizes_;
};

/// No stepper: says why, and nothing else.
template <class S, class F, class Scheme, class MassSpec, ImplicitSolver Solver>
  requires(!State<S> || !MassSpecification<MassSpec>)
class PhiStepper<S, F, Scheme, MassSpec, Solver> {
 public:
  static_assert(StateRefusal<State<S>, S>::is_said);
  static_assert(
      MassSpecification<MassSpec>,
      "phistep: after the scheme comes the mass, mass(2.0) or capacity(matrix), then the solver, newton(options) or "
      "fixed_point()");
  explicit PhiStepper(const S& /*state*/, const auto&... /*any*/) {}
  StepReport step(auto&&... /*any*/) { return {}; }
};

template <class S, class F, class Scheme>
PhiStepper(const S&, F, Scheme) -> PhiStepper<S, F, Scheme>;
template <class S, class F, class Scheme, MassSpecification Mass>
PhiStepper(const S&, F, Scheme, Mass) -> PhiStepper<S, F, Scheme, Mass>;
template <class S, class F, class Scheme, ImplicitSolver Solver>
PhiStepper(const S&, F, Scheme, Solver) -> PhiStepper<S, F, Scheme, UnitMasses, Solver>;
template <class S, class F, class Scheme, MassSpecification Mass, ImplicitSolver Solver>
PhiStepper(const S&, F, Scheme, Mass, Solver) -> PhiStepper<S, F, Scheme, Mass, Solver>;

}}  // namespace phistep::PHISTEP_ABI
