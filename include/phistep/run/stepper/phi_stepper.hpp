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
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/embed/number_parts.hpp"
#include "phistep/force/at.hpp"
#include "phistep/linear/network/network_system.hpp"
#include "phistep/run/control/fixed_step.hpp"
#include "phistep/run/errors/automatic_atol.hpp"
#include "phistep/schemes/kicks.hpp"
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
  using Force = typename SteppedForce<S, F>::type;
  static_assert(!split || std::is_same_v<Force, F>,
                "phistep: no term of a force of complex or other numbers can stand apart from the others");
  using Rhs = RightHandSide<S, Force, Masses, split>;
  using Traits = typename Rhs::Traits;
  /// The class whose step() takes the steps: SchemeOn<Scheme, S> (for φ-methods in schemes/phi.hpp), or with kicks around it KickScheme.
  using Working = TextAtWork<Scheme, S, Rhs, split>;
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
  static_assert(KicksRefusal<F, Scheme, S>::is_said);
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
  /// @param origin  Origin::unedited: the state is what the last step left; saves the check for edits
  StepReport step(S& state, Scalar t, Scalar dt, Origin origin = Origin::unknown) {
    return steps(state, OneStep<Scalar>{t, dt}, origin);
  }

  /// One step, or some where facts.takes_several, each from where the one before ends. What statistics() count as steps are done.
  template <class Steps>
  StepReport steps(S& state, const Steps& all, Origin origin) {
    if constexpr (Traits::valid) {
      follow_size(state);
      if constexpr (Kernel::Transaction::in_registers && needs.passes > 0 && facts.takes_several)
        return take_inlined(state, all, origin);
      else return take(state, all, origin);
    } else {
      return {};
    }
  }

  static constexpr StepperFacts facts{.traces = Working::traces,
                                      .interpolates = Working::interpolates,
                                      .is_sure_inside = Working::is_sure_inside,
                                      .solves_nothing = !needs.solver && !needs.stages && !Working::has_inner_steps,
                                      .reads_weights = needs.solver || needs.stages || Working::reads_weights,
                                      .refactorizes = needs.stages && !Traits::is_affine,
                                      .is_affine = Traits::is_affine,
                                      .takes_several = Kernel::takes_several && !Working::has_inner_steps,
                                      .has_inner_steps = Working::has_inner_steps,
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
  /// @param accept  a judge (step/transaction/trace.hpp)
  StepReport attempt(S& state, Scalar t, Scalar dt, Origin origin, Trace<PlainState<S>>& trace,
                     const Judge<PlainState<S>>& accept) requires(facts.traces.value) {
    if constexpr (Traits::valid) {
      follow_size(state);
      const auto advance = [&](auto& eq) {
        Outcome outcome = take_step(working_, eq);
        if (!failed(outcome)) outcome = working_.error(eq);
        if (!needs.stages && !failed(outcome)) outcome = eq.look_at_end([&] { return working_.reach_end(eq); });
        if (failed(outcome)) return outcome;
        if (!accept(eq.y, std::as_const(eq.next), trace)) return Outcome::error_too_large;
        return working_.reach_end(eq);
      };
      return kernel_.take_traced(state, OneStep<Scalar>{t, dt}, origin, trace, accept, advance,
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
  /// Of the last step: the sizes of its solves' corrections.
  [[nodiscard]] const SolveRecord& last_solve() const { return kernel_.last_solve(); }

  [[nodiscard]] int order() const { return working_.order(); }
  /// Calls the force where `interpolate` needs more of the step from y0 that `attempt` did last with trace.wants_dense. False
  /// where it isn't finite there: then nothing better than the ends is known inside.
  [[nodiscard]] bool know_inside(Scalar dt, const PlainState<S>& y0) {
    return working_.know_inside(kernel_.rhs(), dt, y0);
  }
  /// out = y(t + x dt), 0 < x < 1, of the step from y0 to y1 that `know_inside` was asked about.
  void interpolate(Scalar x, Scalar dt, const PlainState<S>& y0, const PlainState<S>& y1, PlainState<S>& out) const
      requires(facts.interpolates.value) {
    working_.interpolate(x, dt, y0, y1, out);
  }
  [[nodiscard]] const Statistics& statistics() const { return kernel_.rhs().statistics(); }
  /// Of a sum: how often each term was evaluated, in their order.
  [[nodiscard]] auto calls_by_term() const requires is_sum<Unwrapped<F>> {
    std::array<std::int64_t, std::tuple_size_v<decltype(Unwrapped<F>::terms)>> calls;
    calls.fill(statistics().force_calls);
    if constexpr (split)
      for (std::size_t j = 0; const std::size_t place : Parts<Unwrapped<F>>::template places<true>) {
        if constexpr (Working::has_inner_steps) calls[place] = working_.calls(j++);
        else calls[place] = statistics().kick_calls;
      }
    return calls;
  }
  /// How the library solves the linear equations of this scheme, force and mass; "none" where there are none.
  [[nodiscard]] const char* solver_name() const { return kernel_.solver_name(); }
  /// The scheme at work: stage values of the last step, where it has some.
  [[nodiscard]] const Working& working() const { return working_; }

  /// The particles that are computed from now on (base/state/active_set.hpp); null: all. The force stays the same: slopes kept elsewhere hold.
  void set_active(std::shared_ptr<const ActiveSet> active) requires Rhs::takes_active {
    static_assert(
        !Working::looks_back,
        "phistep: generalized_alpha, newmark, hht and bossak carry an acceleration from step to step, which would move "
        "who sleeps: take trapezoidal, tr_bdf2 or an explicit scheme");
    active_ = std::move(active);
    follow_active();
  }
  /// M of the solved blocks, one bound mass each.
  [[nodiscard]] const Masses& masses() const { return kernel_.rhs().masses(); }

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
    forget_known();
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
  /// Counts requests to forget: slopes of this force kept elsewhere are stale where it has changed.
  [[nodiscard]] std::int64_t changes() const { return changes_; }

 private:
  friend StepperInternals;

  PhiStepper(const PlainState<S>& copy, const S& state, F&& psi, Scheme scheme, MassSpec&& mass, Solver solver)
      : scheme_{scheme},
        mass_{std::move(mass)},
        kernel_{state, copy, Rhs{std::move(psi), bind_masses<S>(mass_, copy)}, solver},
        working_{scheme, copy} {
    check_masses();
  }
  /// @throws std::invalid_argument where a mass of motion isn't positive, or M is singular and the scheme or its solver needs M⁻¹
  void check_masses() const {
    constexpr bool has_matrix = requires { typename Solver::LinearSolver; };
    if constexpr (Rhs::drifts) refuse_masses_of_motion(masses());
    else if constexpr (Rhs::may_be_singular)
      if (!(has_matrix && working_.takes_singular_mass())) refuse_singular_masses(masses(), type_of_scheme());
  }
  /// The force as well: only so do the compilers keep a small state in registers from step to step.
  [[gnu::flatten]] StepReport take_inlined(S& state, const auto& all, Origin origin) {
    return take(state, all, origin);
  }
  StepReport take(S& state, const auto& all, Origin origin) {
    const auto accepted = [this] { working_.accepted(); };
    if constexpr (Kernel::steps_in_place)
      if (kernel_.can_step_in_place(state)) {
        const StepReport report =
            kernel_.take_in_place(state, all.t(0), all.dt, origin, [this](auto& eq) { return working_.step(eq); });
        if (report) accepted();
        return report;
      }
    return kernel_.take(
        state, all, origin, [this](auto& eq) PHISTEP_DETAIL_INLINED { return take_step(working_, eq); }, accepted);
  }
  /// Without parameters, which are the program's.
  [[nodiscard]] static std::string type_of_scheme() {
    if constexpr (requires { Scheme::name(); }) return Scheme::name();
    else return "a scheme of the user's own";
  }
  /// Forgets what steps left for the next, as Ψ: the force may jump here. The force's own history stays.
  void forget_known() {
    kernel_.forget_force();
    working_.forget();
  }
  void forget() {
    ++changes_;
    kernel_.reset();
    working_.forget();
  }
  void follow_size(const S& state) {
    if constexpr (static_unknowns<S> != Eigen::Dynamic) return;
    if (kernel_.fits(state)) return;
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
    kernel_.forget_force(true);
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

template <class S, class F, class Scheme, MassSpecification Mass = UnitMasses, ImplicitSolver Solver = Newton<>>
PhiStepper(const S&, F, Scheme, Mass = {}, Solver = {}) -> PhiStepper<S, F, Scheme, Mass, Solver>;
template <class S, class F, class Scheme, ImplicitSolver Solver>
PhiStepper(const S&, F, Scheme, Solver) -> PhiStepper<S, F, Scheme, UnitMasses, Solver>;

}}  // namespace phistep::PHISTEP_ABI
