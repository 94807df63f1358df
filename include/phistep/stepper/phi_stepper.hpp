/// @file
/// One step of the φ-method for M y' = Ψ(t, y) and for motion m v' = Ψ(r, v, t), r' = v:
///
///     r(t+Δt) = r + v Δt + φ Δt²/m (φ Ψ(t+Δt) + (1−φ) Ψ(t))                                                    (1)
///     v(t+Δt) = v +        Δt/m    (φ Ψ(t+Δt) + (1−φ) Ψ(t)),      0 ≤ φ ≤ 1                                     (2)
///
/// φ = 0 is forward Euler, φ = ½ the trapezoidal rule (which the source calls "midpoint"), φ = 1 backward Euler. With (2)
/// in (1), r⁺ = r + Δt [(1−φ) v + φ v⁺]: both lines are one statement about y = (r, v), in either of two forms,
///
///     endpoint   b  = y + (1−φ)Δt M⁻¹Ψ(t, y)            forward Euler over (1−φ)Δt                              (3)
///                y⁺ = b + φΔt M⁻¹Ψ(t+Δt, y⁺)            backward Euler over φΔt: a resolve                      (4)
///     stage      Y  = y + φΔt M⁻¹Ψ(t+φΔt, Y)            the same two in the other order                         (5)
///                y⁺ = Y + (1−φ)Δt M⁻¹Ψ(t+φΔt, Y)                                                                (6)
///
/// and with a pair (φ_force, φ_drift) of its own for v and for r. Velocity Verlet is (0,1) over Δt/2, then (1,0) over Δt/2:
///
///     v½ = v + ½Δt M⁻¹Ψ(t, r, v),   r⁺ = r + Δt v½,                                                             (7)
///     v⁺ = v½ + ½Δt M⁻¹Ψ(t+Δt, r⁺, v⁺)                  a resolve for v alone where Ψ depends on v              (8)
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "phistep/core/archive.hpp"
#include "phistep/core/phi.hpp"
#include "phistep/core/version.hpp"
#include "phistep/force/at.hpp"
#include "phistep/linear/mass.hpp"
#include "phistep/resolve/newton.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/parts.hpp"
#include "phistep/state/unknowns.hpp"
#include "phistep/stepper/error_estimate.hpp"
#include "phistep/stepper/fixed_point_resolvent.hpp"
#include "phistep/stepper/kernel.hpp"
#include "phistep/stepper/local_resolvent.hpp"
#include "phistep/stepper/right_hand_side.hpp"
#include "phistep/stepper/splitting.hpp"
#include "phistep/stepper/transaction.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The φ-step.
template <class Force, class Drift, Form form, State S>
class Row<PhiScheme<Force, Drift, form>, S> : public RowDefaults {
 public:
  using Scheme = PhiScheme<Force, Drift, form>;
  using Scalar = ScalarOf<S>;
  /// The pair (φ, 0) without velocities solves nothing. Ψ⁺ serves the next step where it is known for nothing and errors
  /// in it die out: φ > ½ (an error in a reused Ψ is multiplied by −(1−φ)/φ each step).
  template <class Rhs>
  static constexpr KernelNeeds needs = [] {
    const bool solver = !Scheme::is_explicit && (Rhs::couples_unknowns || !is_zero_phi<Drift>);
    return KernelNeeds{.solver = solver, .carries = solver && form == Form::endpoint && can_carry<Rhs>};
  }();

  Row(Scheme scheme, const auto& /*y*/) : scheme_{scheme} {}
  [[nodiscard]] const Scheme& scheme() const { return scheme_; }
  [[nodiscard]] int order() const { return scheme_.order(); }

  [[nodiscard]] Outcome advance(auto& kernel, auto& step) const {
    if constexpr (form == Form::stage) return stage(kernel, step);
    else return endpoint(kernel, step);
  }

  static constexpr bool traces = form == Form::endpoint && !Scheme::is_pair;
  /// φ = ½ looks back a step.
  [[nodiscard]] bool estimates(const auto& trace) const { return order() == 1 || trace.dt_before != 0; }

  /// (3) and (4) with both slopes, and the local error e = y⁺ − y(t+Δt) from them:
  ///
  ///     e = (φ−½)Δt (y'⁺ − y') + (6φ−2) Δt³/12 y‴
  ///
  /// of which the second part is all at φ = ½, and y‴ the second difference of three slopes: there, e is the difference to
  /// the Adams-Bashforth rule of order 2 by Milne's device (P. M. Gresho, R. L. Lee & R. L. Sani, in Recent Advances in
  /// Numerical Methods in Fluids 1 (1980) 27).
  template <class Kernel>
  [[nodiscard]] Outcome trace(Kernel& kernel, typename Kernel::Data& step) const {
    const Scalar phi = scheme_.force.template value<Scalar>(), dt = step.dt;
    auto& trace = *step.trace;
    if (const Outcome outcome = kernel.start(step); outcome != Outcome::success) return outcome;
    kernel.move(step, (1 - phi) * dt);
    if (phi == 0) {
      if (!kernel.rhs().is_finite(step.next)) return Outcome::non_finite_state;
      if (!kernel.rhs().slope(step.t + dt, step.next, trace.end, step.psi)) return Outcome::non_finite_force;
    } else {
      copy_blocks<S>(trace.end, step.next);  // b
      const bool has_past = trace.dt_before != 0;
      if (has_past) predict(trace, step.y, dt);
      if (const Outcome outcome =
              kernel.resolve_predicted(step, {phi * dt, phi * dt}, step.t + dt, trace.end, has_past);
          outcome != Outcome::success)
        return outcome;
      for_each_block([by = 1 / (phi * dt)](auto, auto& end, const auto& y) { end = (y - end) * by; },
                     Blocks<S>::all(trace.end), Blocks<S>::all(step.next));
    }
    trace.has_slopes = true;
    trace.has_error = estimates(trace);
    if (!trace.has_error) return Outcome::success;
    for_each_block(
        [by = (phi - Scalar{0.5}) * dt](auto, auto& e, const auto& start, const auto& end) { e = by * (end - start); },
        Blocks<S>::all(trace.error), Blocks<S>::all(trace.start), Blocks<S>::all(trace.end));
    if (phi > 0 && phi < 1 && trace.dt_before != 0) add_milne(trace, dt, 6 * phi - 2);
    return phi == 0 ? Outcome::success : kernel.filter(trace.error);
  }

 private:
  /// (3) and (4)
  template <class Kernel>
  [[nodiscard]] Outcome endpoint(Kernel& kernel, typename Kernel::Data& step) const {
    const Scalar phi = scheme_.force.template value<Scalar>(), drift = scheme_.drift.template value<Scalar>();
    const Scalar dt = step.dt;
    if constexpr (Scheme::is_explicit) {
      return kernel.forward(step, {dt, (1 - drift) * dt, drift * dt});
    } else {
      if (phi == 0) return kernel.forward(step, {dt, (1 - drift) * dt, drift * dt});
      if (phi == 1) kernel.coast(step, (1 - drift) * dt);
      else if (const Outcome outcome = kernel.forward(step, {(1 - phi) * dt, (1 - drift) * dt, 0});
               outcome != Outcome::success)
        return outcome;
      const Gamma<Scalar> gamma{phi * dt, drift * dt};
      const Outcome outcome = kernel.resolve(step, gamma, step.t + dt);
      if constexpr (Kernel::carries)
        if (outcome == Outcome::success && phi > Scalar{0.5} && phi < 1) {
          kernel.recover(step, gamma);
          step.psi_next_known = true;
        }
      return outcome;
    }
  }

  /// (5) and (6), the latter as y⁺ = Y + (1−φ)/φ (Y − y)
  template <class Kernel>
  [[nodiscard]] Outcome stage(Kernel& kernel, typename Kernel::Data& step) const {
    const Scalar phi = scheme_.force.template value<Scalar>(), dt = step.dt;
    if constexpr (Scheme::is_explicit) {
      return kernel.forward(step, {dt, dt, 0});
    } else {
      if (phi == 0) return kernel.forward(step, {dt, dt, 0});
      kernel.coast(step, 0);
      if (const Outcome outcome = kernel.resolve(step, {phi * dt, phi * dt}, step.t + phi * dt);
          outcome != Outcome::success)
        return outcome;
      kernel.rhs().drift(step.next, (1 - phi) * dt);
      kernel.add_increment(step, (1 - phi) / phi);
      return Kernel::Rhs::is_finite(step.next) ? Outcome::success : Outcome::non_finite_state;
    }
  }

  [[no_unique_address]] Scheme scheme_;
};

/// Velocity Verlet. Without velocities nothing is solved, and its second Ψ is the next step's first.
template <State S>
class Row<VelocityVerlet, S> : public RowDefaults {
 public:
  template <class Rhs>
  static constexpr KernelNeeds needs{
      .solver = Rhs::couples_unknowns, .position = false, .carries = !Rhs::couples_unknowns && can_carry<Rhs>};

  Row(VelocityVerlet, const auto& /*y*/) {}
  [[nodiscard]] static VelocityVerlet scheme() { return {}; }
  [[nodiscard]] static int order() { return VelocityVerlet::order(); }

  /// (7) and (8)
  template <class Kernel>
  [[nodiscard]] static Outcome advance(Kernel& kernel, typename Kernel::Data& step) {
    const ScalarOf<S> half = step.dt / 2, t1 = step.t + step.dt;
    if (const Outcome outcome = kernel.forward(step, {half, 0, step.dt}); outcome != Outcome::success) return outcome;
    step.psi_next_known = Kernel::carries;
    if (step.trace == nullptr) return kernel.resolve(step, {half, 0}, t1);
    copy_blocks<S>(step.trace->end, step.next);
    // The second half kick is predicted to be the first.
    for_each_block([](auto, auto& to, const auto& y, const auto& kicked) { to = kicked + (kicked - y); },
                   Blocks<S>::all(step.trace->predicted), Blocks<S>::all(step.y), Blocks<S>::all(step.next));
    return kernel.resolve(step, {half, 0}, t1, step.trace->predicted);
  }

  static constexpr bool traces = true;
  [[nodiscard]] static bool estimates(const auto& trace) { return trace.dt_before != 0; }

  /// The same with both slopes, from the half kicks, and the local error: of r, −Δt³/6 r‴ = −Δt²/6 (a⁺ − a); of v that of
  /// the trapezoidal rule.
  template <class Kernel>
  [[nodiscard]] static Outcome trace(Kernel& kernel, typename Kernel::Data& step) {
    auto& trace = *step.trace;
    if (const Outcome outcome = advance(kernel, step); outcome != Outcome::success) return outcome;
    for_each_block(
        [by = 2 / step.dt](auto, auto& start, auto& end, const auto& y, const auto& next) {
          start = by * (end - y);  // end holds v½
          end = by * (next - end);
        },
        Blocks<S>::solved(trace.start), Blocks<S>::solved(trace.end), Blocks<S>::solved(step.y),
        Blocks<S>::solved(step.next));
    position_of<S>(trace.start) = velocity_of<S>(step.y);
    position_of<S>(trace.end) = velocity_of<S>(step.next);
    trace.has_slopes = true;
    trace.has_error = estimates(trace);
    if (!trace.has_error) return Outcome::success;
    set_milne(trace, step.dt);
    position_of<S>(trace.error) = (-step.dt * step.dt / 6) * (velocity_of<S>(trace.end) - velocity_of<S>(trace.start));
    return needs<typename Kernel::Rhs>.solver ? kernel.filter(trace.error) : Outcome::success;
  }
};

/// Steps a state S under a force F by the φ-method, or by any other scheme that is a row over the same kernel.
/// @tparam MassSpec  what mass(…) or capacity(…) returned, UnitMasses for M = 1
/// @tparam Solver    how the implicit equations are solved
template <class S, class F, class Scheme, class MassSpec = UnitMasses, ImplicitSolver Solver = Newton<>>
class PhiStepper {
  using Masses = decltype(bind_masses<S>(std::declval<const MassSpec&>(), std::declval<const PlainState<S>&>()));
  static constexpr bool split = is_split<Unwrapped<F>, Scheme>;
  using Rhs = RightHandSide<S, F, Masses, split>;
  using Traits = typename Rhs::Traits;
  using Plainly = phistep::Row<Scheme, S>;
  using Row = std::conditional_t<split, SplitRow<Plainly, S, Rhs>, Plainly>;
  static constexpr KernelNeeds needs = [] {
    if constexpr (Traits::valid) return Row::template needs<Rhs>;
    else return KernelNeeds{};
  }();
  using Kernel = phistep::Kernel<S, Rhs, Solver, needs>;

 public:
  using Scalar = ScalarOf<S>;
  using StateType = S;
  using SchemeType = Scheme;
  /// What a repetition of the run from here needs to know beside the state.
  struct Checkpoint {
    typename Rhs::Memory memory;
    typename Row::Progress progress;
  };

  static_assert(Refusal<Traits::fault, Rhs::drifts>::is_said);
  static_assert(
      suits<Unwrapped<F>, Scheme>,
      "phistep: at(scheme, term) takes forward_euler or the stepper's own scheme (terms at other phi: not yet)");
  static_assert(!is_at<F>, "phistep: at(scheme, term) marks a term of a sum, there is no sum here");
  static_assert(
      !Scheme::is_pair || Rhs::drifts,
      "phistep: a pair (phi_force, phi_drift) and velocity_verlet need a motion (r, v), not a first-order state");

  /// @param state   gives the sizes; it is not kept
  /// @param psi     the force Ψ, copied; wrap it in std::ref to keep it outside
  /// @param scheme  forward_euler, trapezoidal, backward_euler, midpoint, velocity_verlet, phi(0.7), tr_bdf2, …
  /// @param mass    mass(m) or capacity(C); M = 1 if left out
  /// @param solver  newton(options) or newton<LinearSolver>(options)
  /// @throws std::invalid_argument where sizes or masses can't work
  PhiStepper(const S& state, F psi, Scheme scheme, MassSpec mass = {}, Solver solver = {})
      : scheme_{scheme},
        mass_{std::move(mass)},
        kernel_{state, Rhs{std::move(psi), bind_masses<S>(mass_, Kernel::Transaction::copy_of(state))}, solver},
        row_{scheme, Kernel::Transaction::copy_of(state)} {}
  PhiStepper(const S& state, F psi, Scheme scheme, Solver solver) requires std::is_same_v<MassSpec, UnitMasses>
      : PhiStepper{state, std::move(psi), scheme, UnitMasses{}, solver} {}

  /// Advances the state from t to t + dt. [time] dt < 0 steps backward.
  /// On any failure the state keeps every bit; an exception thrown by the force passes through, likewise. The next step is
  /// then that of a new stepper with the same history.
  StepReport step(S& state, Scalar t, Scalar dt) { return step(state, t, dt, Origin::unknown); }

  /// With Origin::unedited the caller vouches that the state is what the last step left, and saves the check.
  StepReport step(S& state, Scalar t, Scalar dt, Origin origin) {
    if constexpr (Traits::valid) {
      if constexpr (static_unknowns<S> == Eigen::Dynamic)
        if (!kernel_.fits(state)) resize(state);
      const StepReport report =
          kernel_.run(state, t, dt, origin, false, [this](auto& step) { return row_.advance(kernel_, step); });
      if (report) row_.accepted();
      return report;
    } else {
      return {};
    }
  }

  /// Whether `attempt` can say how large a step's error is: some schemes always, some once they have a past, some never
  /// (StepDoubling serves those).
  static constexpr bool traces = Row::traces;
  static constexpr bool is_affine = Traits::is_affine;
  [[nodiscard]] bool estimates(const Trace<PlainState<S>>& trace) const {
    if constexpr (traces) return row_.estimates(trace);
    else return false;
  }
  /// A step that becomes the state only if accept(y, y⁺, trace) says so; otherwise Outcome::error_too_large, and the state
  /// keeps every bit. The trace tells of the step what it can. What a failed try has found serves the next: whoever gives up
  /// calls forget_solves().
  template <class Accept>
  StepReport attempt(S& state, Scalar t, Scalar dt, Origin origin, Trace<PlainState<S>>& trace,
                     Accept&& accept) requires traces {
    if constexpr (Traits::valid) {
      if constexpr (static_unknowns<S> == Eigen::Dynamic)
        if (!kernel_.fits(state)) resize(state);
      const StepReport report = kernel_.run(state, t, dt, origin, true, [&](auto& step) {
        step.trace = &trace;
        trace.dt = dt;
        trace.has_slopes = trace.has_error = false;
        if (const Outcome outcome = row_.trace(kernel_, step); outcome != Outcome::success) return outcome;
        return accept(step.y, std::as_const(step.next), trace) ? Outcome::success : Outcome::error_too_large;
      });
      if (report) row_.accepted();
      return report;
    } else {
      return {};
    }
  }
  /// out = y' at (t, y): for motion v and M⁻¹Ψ. One force call; false where it isn't finite.
  [[nodiscard]] bool slope(Scalar t, const PlainState<S>& y, PlainState<S>& out) {
    RateOf<S> psi = make_rate<S>(y);
    return kernel_.rhs().whole_slope(t, y, out, psi);
  }
  /// Of the last step: the sizes of its solves' corrections.
  [[nodiscard]] const Failure& history() const { return kernel_.history(); }

  [[nodiscard]] int order() const { return row_.order(); }
  /// The power of Δt with which the error estimate of `attempt` goes.
  [[nodiscard]] int error_order() const {
    if constexpr (requires { row_.error_order(); }) return row_.error_order();
    else return row_.order() + 1;
  }
  /// Whether its steps solve no equations, so that stability keeps Δt within what slopes at both ends can tell.
  static constexpr bool solves_nothing = !needs.solver && !needs.stages;
  /// Whether each step makes its matrix anew, so that keeping Δt spares nothing.
  static constexpr bool refactorises = needs.stages && !Traits::is_affine;
  /// Whether the scheme knows the solution inside the step just accepted better than its ends tell.
  static constexpr bool interpolates = Row::interpolates;
  /// Where in a step its interpolant is worst.
  static constexpr std::array<double, 2> doubtful_at = Row::doubtful_at;
  /// out = y(t + x dt), 0 < x < 1, of the step from y0 to y1 that `attempt` did last with trace.wants_dense.
  void interpolate(Scalar x, Scalar dt, const PlainState<S>& y0, const PlainState<S>& y1, PlainState<S>& out) const
      requires(interpolates) {
    row_.interpolate(x, dt, y0, y1, out);
  }
  [[nodiscard]] const Statistics& statistics() const { return kernel_.rhs().statistics(); }
  /// How the library solves the linear equations of this scheme, force and mass; "none" where there are none.
  [[nodiscard]] const char* solver_name() const { return kernel_.solver_name(); }
  /// The scheme at work: stage values of the last step, where it has some.
  [[nodiscard]] const Row& row() const { return row_; }

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
  [[nodiscard]] Checkpoint checkpoint() const { return {memory(), row_.progress()}; }
  /// Matrices stay: what they are worth shows in the next solve.
  void restore(Checkpoint checkpoint) {
    kernel_.rhs().set_memory(std::move(checkpoint.memory));
    kernel_.forget_force();
    row_.forget();
    row_.resume(checkpoint.progress);
  }
  /// Writes all that later steps depend on beside the state and the parameters given here: the history, how far the scheme
  /// has come, Ψ, Jacobian and factors where they are carried from step to step, and the counts.
  void save(Writer& out) const { save_parts(out, row_, kernel_); }
  /// Reads what save() wrote for a stepper made alike; then() reads what follows. The next steps give the bits that the
  /// saved one would have given. @throws CheckpointError, before anything has changed
  void load(Reader& in, auto&& then) { load_parts(in, then, row_, kernel_); }
  /// Forgets what solves have left, Jacobians and factors, as a step that fails does.
  void forget_solves() { kernel_.forget_solves(); }
  /// Starts anew: forgets all that is carried from step to step (Ψ, Jacobian, factors), and that there were steps.
  /// Never needed after an edit of the state.
  void reset() {
    forget();
    row_.reset();
  }

  /// How often something was forgotten by request: who keeps slopes of this force has to forget them, too.
  [[nodiscard]] std::int64_t changes() const { return changes_; }

 private:
  void forget() {
    ++changes_;
    kernel_.reset();
    row_.forget();
  }
  void resize(const S& state) {
    // What may throw comes first: a stepper half resized would write out of bounds at the next step.
    const auto copy = Kernel::Transaction::copy_of(state);
    auto masses = bind_masses<S>(mass_, copy);
    Row fresh = row_;
    fresh.resize(copy);
    kernel_.resize(state, copy, std::move(masses));
    row_ = std::move(fresh);
  }

  [[no_unique_address]] Scheme scheme_;
  [[no_unique_address]] MassSpec mass_;
  Kernel kernel_;
  [[no_unique_address]] Row row_;
  std::int64_t changes_ = 0;
};

/// No stepper: says why, and nothing else.
template <class S, class F, class Scheme, class MassSpec, ImplicitSolver Solver>
  requires(!State<S> || !is_mass_spec<MassSpec>)
class PhiStepper<S, F, Scheme, MassSpec, Solver> {
 public:
  static_assert(StateRefusal<State<S>>::is_said);
  static_assert(
      is_mass_spec<MassSpec>,
      "phistep: after the scheme comes the mass, mass(2.0) or capacity(matrix), then the solver, newton(options) or "
      "fixed_point()");
  explicit PhiStepper(const S& /*state*/, const auto&... /*any*/) {}
  StepReport step(auto&&... /*any*/) { return {}; }
};

template <class S, class F, class Scheme>
PhiStepper(const S&, F, Scheme) -> PhiStepper<S, F, Scheme>;
template <class S, class F, class Scheme>
PhiStepper(const S&, F, Scheme, UnitMasses) -> PhiStepper<S, F, Scheme>;
template <class S, class F, class Scheme, class... M>
PhiStepper(const S&, F, Scheme, MassList<M...>) -> PhiStepper<S, F, Scheme, MassList<M...>>;
template <class S, class F, class Scheme, ImplicitSolver Solver>
PhiStepper(const S&, F, Scheme, Solver) -> PhiStepper<S, F, Scheme, UnitMasses, Solver>;
template <class S, class F, class Scheme, ImplicitSolver Solver>
PhiStepper(const S&, F, Scheme, UnitMasses, Solver) -> PhiStepper<S, F, Scheme, UnitMasses, Solver>;
template <class S, class F, class Scheme, class... M, ImplicitSolver Solver>
PhiStepper(const S&, F, Scheme, MassList<M...>, Solver) -> PhiStepper<S, F, Scheme, MassList<M...>, Solver>;

}  // namespace phistep::inline PHISTEP_ABI
