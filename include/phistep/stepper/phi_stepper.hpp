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

#include <type_traits>
#include <utility>

#include "phistep/core/phi.hpp"
#include "phistep/core/version.hpp"
#include "phistep/linear/mass.hpp"
#include "phistep/resolve/newton.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/stepper/fixed_point_resolvent.hpp"
#include "phistep/stepper/local_resolvent.hpp"
#include "phistep/stepper/resolvent.hpp"
#include "phistep/stepper/right_hand_side.hpp"
#include "phistep/stepper/transaction.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Steps a state S under a force F by the φ-method.
/// @tparam MassList  what mass(…) or capacity(…) returned, UnitMasses for M = 1
/// @tparam Solver    how the implicit equations are solved
template <State S, class F, class Scheme, class MassSpec = UnitMasses, ImplicitSolver Solver = Newton<>>
class PhiStepper {
  using Masses = decltype(bind_masses<S>(std::declval<const MassSpec&>(), std::declval<const PlainState<S>&>()));
  using Rhs = RightHandSide<S, F, Masses>;
  using Traits = typename Rhs::Traits;
  static constexpr bool is_verlet = std::is_same_v<Scheme, VelocityVerlet>;

 public:
  using Scalar = ScalarOf<S>;

  static_assert(Traits::valid || !Rhs::drifts,
                "phistep: the force of a motion must be callable as f(r), f(r, v) or f(r, v, t), or be a struct with "
                "add(t, y, out)");
  static_assert(Traits::valid || Rhs::drifts,
                "phistep: the force of a first-order state must be callable as f(y) or f(y, t), or be a struct with "
                "add(t, y, out)");
  static_assert(
      !Scheme::is_pair || Rhs::drifts,
      "phistep: a pair (phi_force, phi_drift) and velocity_verlet need a motion (r, v), not a first-order state");

  /// @param state   gives the sizes; it is not kept
  /// @param psi     the force Ψ, copied; wrap it in std::ref to keep it outside
  /// @param scheme  forward_euler, trapezoidal, backward_euler, midpoint, velocity_verlet, phi(0.7), …
  /// @param mass    mass(m) or capacity(C); M = 1 if left out
  /// @param solver  newton(options) or newton<LinearSolver>(options)
  /// @throws std::invalid_argument where sizes or masses can't work
  PhiStepper(const S& state, F psi, Scheme scheme, MassSpec mass = {}, Solver solver = {})
      : scheme_{scheme},
        mass_{std::move(mass)},
        rhs_{std::move(psi), bind_masses<S>(mass_, Transaction::copy_of(state))},
        transaction_{state},
        resolvent_{Transaction::copy_of(state), rhs_, solver} {}
  PhiStepper(const S& state, F psi, Scheme scheme, Solver solver) requires std::is_same_v<MassSpec, UnitMasses>
      : PhiStepper{state, std::move(psi), scheme, UnitMasses{}, solver} {}

  /// Advances the state from t to t + dt. [time] dt < 0 steps backward.
  /// On any failure the state keeps every bit; an exception thrown by the force passes through, likewise.
  StepReport step(S& state, Scalar t, Scalar dt) { return step(state, t, dt, Origin::unknown); }

  /// With Origin::unedited the caller vouches that the state is what the last step left, and saves the check.
  StepReport step(S& state, Scalar t, Scalar dt, Origin origin) {
    if constexpr (Traits::valid) {
      if constexpr (static_unknowns<S> == Eigen::Dynamic)
        if (!transaction_.fits(state)) resize(state);
      return transaction_.run(rhs_, state, t, dt, origin, [this](Data& step) { return advance(step); });
    } else {
      return {};
    }
  }

  [[nodiscard]] int order() const { return scheme_.order(); }
  [[nodiscard]] const Statistics& statistics() const { return rhs_.statistics(); }

  /// The force, to change its parameters between steps; what was known of the old one is forgotten.
  [[nodiscard]] auto& force() {
    reset();
    return rhs_.force();
  }
  /// The committed history of a force with memory.
  [[nodiscard]] const auto& memory() const { return rhs_.memory(); }
  void set_memory(typename Rhs::Memory memory) {
    rhs_.set_memory(std::move(memory));
    reset();
  }
  /// Forgets all that is carried from step to step: Ψ, Jacobian, factors. Never needed after an edit of the state.
  void reset() {
    transaction_.reset();
    resolvent_.reset();
  }

 private:
  /// Verlet without velocities and the pair (φ, 0) without velocities solve nothing.
  static constexpr bool needs_solver = [] {
    if constexpr (!Traits::valid || (Scheme::is_explicit && !is_verlet)) return false;
    else if constexpr (is_verlet) return Rhs::couples_unknowns;
    else return Rhs::couples_unknowns || !is_zero_phi<decltype(Scheme::drift)>;
  }();
  /// Ψ⁺ serves the next step where it is known for nothing and errors in it die out: Verlet's second call, and φ > ½
  /// (an error in a reused Ψ is multiplied by −(1−φ)/φ each step).
  static constexpr bool carries = Traits::valid && !remembers<F> && !Traits::is_lookup &&
                                  (is_verlet ? !Rhs::couples_unknowns : needs_solver && Scheme::form == Form::endpoint);

  struct NoResolvent {
    NoResolvent(const auto&...) {}
    static void reset() {}
    static void resize(const auto&, const auto&) {}
  };
  template <bool needed>
  static auto resolvent_type() {
    if constexpr (needed) return ResolventFor<S, Rhs, Solver, !is_verlet>{};
    else return std::type_identity<NoResolvent>{};
  }
  using Resolvent = typename decltype(resolvent_type<needs_solver>())::type;
  using Transaction = phistep::Transaction<S, Rhs, carries>;
  using Data = typename Transaction::Data;

  [[nodiscard]] Outcome advance(Data& step) {
    if constexpr (is_verlet) return verlet(step);
    else if constexpr (Scheme::form == Form::stage) return stage(step);
    else return endpoint(step);
  }

  /// (3) and (4)
  [[nodiscard]] Outcome endpoint(Data& step) {
    const Scalar phi = scheme_.force.template value<Scalar>(), drift = scheme_.drift.template value<Scalar>();
    const Scalar dt = step.dt;
    if constexpr (Scheme::is_explicit) {
      return forward(step, {dt, (1 - drift) * dt, drift * dt});
    } else {
      if (phi == 0) return forward(step, {dt, (1 - drift) * dt, drift * dt});
      if (phi == 1) coast(step, (1 - drift) * dt);
      else if (const Outcome outcome = forward(step, {(1 - phi) * dt, (1 - drift) * dt, 0});
               outcome != Outcome::success)
        return outcome;
      const Outcome outcome = resolve(step, {phi * dt, drift * dt}, step.t + dt);
      if constexpr (carries)
        if (outcome == Outcome::success && phi > Scalar{0.5} && phi < 1) {
          // Where nothing was solved, psi is Ψ(t+Δt) already.
          if (Rhs::couples_unknowns || drift != 0) resolvent_.recover(rhs_, phi * dt, step.psi);
          step.psi_next_known = true;
        }
      return outcome;
    }
  }

  /// (5) and (6), the latter as y⁺ = Y + (1−φ)/φ (Y − y)
  [[nodiscard]] Outcome stage(Data& step) {
    const Scalar phi = scheme_.force.template value<Scalar>(), dt = step.dt;
    if constexpr (Scheme::is_explicit) {
      return forward(step, {dt, dt, 0});
    } else {
      if (phi == 0) return forward(step, {dt, dt, 0});
      copy_blocks<S>(step.next, step.y);
      if (const Outcome outcome = resolve(step, {phi * dt, phi * dt}, step.t + phi * dt); outcome != Outcome::success)
        return outcome;
      if constexpr (Rhs::drifts) rhs_.drift(step.next, (1 - phi) * dt);
      resolvent_.add_increment((1 - phi) / phi, step.next);
      return rhs_.is_finite(step.next) ? Outcome::success : Outcome::non_finite_state;
    }
  }

  /// (7) and (8)
  [[nodiscard]] Outcome verlet(Data& step) {
    const Scalar half = step.dt / 2, t1 = step.t + step.dt;
    if (const Outcome outcome = forward(step, {half, 0, step.dt}); outcome != Outcome::success) return outcome;
    step.psi_next_known = carries;
    return resolve(step, {half, 0}, t1);
  }

  /// next = y + γ M⁻¹Ψ(t, y)
  [[nodiscard]] Outcome forward(Data& step, const Advance<Scalar>& by) {
    const bool finite = step.psi_known
                            ? rhs_.advance(step.next, step.y, by, RateOf<S>::blocks(std::as_const(step.psi)), step.psi)
                            : rhs_.advance(step.next, step.y, by, rhs_.evaluate(step.t, step.y, step.psi), step.psi);
    return finite ? Outcome::success : Outcome::non_finite_state;
  }
  /// next = y, drifted: what forward Euler does with no weight on Ψ
  void coast(Data& step, Scalar drift) {
    copy_blocks<S>(step.next, step.y);
    rhs_.drift(step.next, drift);
  }
  /// next = next + γ M⁻¹Ψ(t, next), where Ψ ignores what it moves
  [[nodiscard]] Outcome kick(Data& step, Scalar gamma, Scalar t) {
    const auto kicked = [&](const auto& psi) {
      return rhs_.kick(step.next, gamma, psi, step.psi) ? Outcome::success : Outcome::non_finite_state;
    };
    if constexpr (!carries) return kicked(rhs_.evaluate(t, step.next, step.psi));
    rhs_.evaluate_into(t, step.next, step.psi);  // a copy: the user's own array may change before the next step
    return kicked(RateOf<S>::blocks(std::as_const(step.psi)));
  }
  /// next = b on entry, the solution of M (next − b) = γ Ψ(t, next) on exit
  [[nodiscard]] Outcome resolve(Data& step, const Gamma<Scalar>& gamma, Scalar t) {
    if constexpr (!Rhs::couples_unknowns)
      if (gamma.drift == 0) return kick(step, gamma.force, t);
    if constexpr (needs_solver) {
      const Outcome outcome = resolvent_.resolve(rhs_, gamma, t, step.next, step.y, step.psi, transaction_.failure());
      if (outcome != Outcome::success) return outcome;
      return rhs_.is_finite(step.next) ? Outcome::success : Outcome::non_finite_state;
    }
    return Outcome::success;
  }

  void resize(const S& state) {
    // What may throw comes first: a stepper half resized would write out of bounds at the next step.
    const auto copy = Transaction::copy_of(state);
    auto masses = bind_masses<S>(mass_, copy);
    Transaction fresh{state};
    resolvent_.resize(copy, rhs_);
    rhs_.rebind(std::move(masses));
    transaction_ = std::move(fresh);
  }

  [[no_unique_address]] Scheme scheme_;
  [[no_unique_address]] MassSpec mass_;
  Rhs rhs_;
  Transaction transaction_;
  [[no_unique_address]] Resolvent resolvent_;
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
