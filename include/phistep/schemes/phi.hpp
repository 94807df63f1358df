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
/// and with a pair (φ_force, φ_drift) of its own for v and for r. The local error of (4), y⁺ − y(t+Δt), is
///
///     e = (φ−½)Δt (y'⁺ − y') + (6φ−2) Δt³/12 y‴                                                                 (7)
///
/// of which the second part is all at φ = ½, and y‴ the second difference of three slopes: there, e is the difference to
/// the Adams-Bashforth rule of order 2 by Milne's device (P. M. Gresho, R. L. Lee & R. L. Sani, in Recent Advances in
/// Numerical Methods in Fluids 1 (1980) 27).
///
/// Rannacher's start (Rannacher, Numer. Math. 43 (1984) 309; Giles & Carter, J. Comput. Finance 9 (2006) 89): the first
/// steps as two backward Euler half steps each,
///
///     y½ = y  + ½Δt M⁻¹Ψ(t+½Δt, y½),     y⁺ = y½ + ½Δt M⁻¹Ψ(t+Δt, y⁺),                                          (8)
///
/// then the trapezoidal rule, whose resolve has the coefficient ½Δt too: one matrix for the whole run.
#pragma once

#include <stdexcept>

#include "phistep/base/facts/phi.hpp"
#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/kernel/scheme_on.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Force, class Drift, Form form, State S>
class SchemeOn<PhiScheme<Force, Drift, form>, S> : public SchemeDefaults {
 public:
  using Scheme = PhiScheme<Force, Drift, form>;
  using Scalar = ScalarOf<S>;
  /// The pair (φ, 0) without velocities solves nothing. `carries`: Ψ⁺ for the next step. A traced step has it of a force call
  /// (TracedEquation::reach_end), at any φ. A plain step has it out of the solve, and leaves it where errors in it die out: each step
  /// multiplies an error in a reused Ψ by −(1−φ)/φ, so for ½ < φ < 1 (φ = 1 asks for none): leaves_force().
  template <class Rhs>
  static constexpr KernelNeeds needs = [] {
    const bool solver = !is_zero_phi<Force> && (Rhs::couples_unknowns || !is_zero_phi<Drift>);
    return KernelNeeds{.solver = solver,
                       .carries = solver && form == Form::endpoint && can_carry<Rhs>,
                       .passes = is_zero_phi<Force> ? 1 : 0};
  }();
  static constexpr bool traces = form == Form::endpoint && !Scheme::facts.motion_only;

  SchemeOn(Scheme scheme, const auto& /*y*/) : scheme_{scheme} {}
  [[nodiscard]] const Scheme& scheme() const { return scheme_; }
  [[nodiscard]] int order() const { return scheme_.order(); }
  /// At φ = 1 a step depends on its start by M y alone.
  [[nodiscard]] bool takes_singular_mass() const {
    return scheme_.force.template value<double>() == 1 && scheme_.drift.template value<double>() == 1;
  }
  /// φ = ½ estimates from the step before.
  [[nodiscard]] bool estimates(const auto& trace) const { return order() == 1 || trace.dt_before != 0; }

  [[nodiscard]] bool leaves_force() const {
    const auto phi = scheme_.force.template value<Scalar>();
    return phi > Scalar{0.5} && phi < 1;
  }

  [[nodiscard, gnu::always_inline]] inline Outcome step(auto& eq) const {
    const Scalar dt = eq.dt, phi = scheme_.force.template value<Scalar>(),
                 drift = scheme_.drift.template value<Scalar>();
    if (phi == 0) return euler(eq, form == Form::stage ? 0 : drift);
    if constexpr (is_zero_phi<Force>) return Outcome::success;
    else if constexpr (form == Form::stage) return stage(eq, phi);
    else {
      const Gamma<Scalar> gamma{phi * dt, drift * dt};
      if (const Outcome bad = eq.start(gamma); failed(bad)) return bad;  // traced steps alone, as predict
      if (const Outcome bad = eq.forward({(1 - phi) * dt, (1 - drift) * dt, 0}); failed(bad)) return bad;  // (3)
      eq.predict(dt);
      return eq.resolve(gamma, eq.t + dt);  // (4)
    }
  }
  /// (7)
  [[nodiscard]] Outcome error(auto& eq) const {
    const Scalar phi = scheme_.force.template value<Scalar>();
    if (phi == 0)
      if (const Outcome bad = eq.end(); failed(bad)) return bad;
    auto& trace = eq.trace;
    trace.has_slopes = true;
    eq.complete_start();
    trace.has_error = estimates(trace);
    if (!trace.has_error) return Outcome::success;
    assign<S>(trace.error, (phi - Scalar{0.5}) * eq.dt * (in<S>(trace.end) - in<S>(trace.start)));
    if (phi == 0) return Outcome::success;
    if (phi < 1 && trace.dt_before != 0) add<S>(trace.error, milne(trace, eq.dt, 6 * phi - 2));
    return eq.filter(trace.error);
  }

 private:
  /// φ = 0: all of the step is forward Euler; (φ_f, φ_d) = (0, 1) drifts with the new velocity.
  [[nodiscard, gnu::always_inline]] inline Outcome euler(auto& eq, Scalar drift) const {
    return eq.euler(
        Advance{eq.dt, unless<fixes<Drift, 2>>((1 - drift) * eq.dt), unless<is_zero_phi<Drift>>(drift * eq.dt)});
  }
  /// (5) and (6), the latter as y⁺ = Y + (1−φ)/φ (Y − y)
  template <class Eq>
  [[nodiscard]] static Outcome stage(Eq& eq, Scalar phi) {
    const Scalar dt = eq.dt;
    copy_blocks<S>(eq.next, eq.y);
    if (const Outcome bad = eq.resolve({phi * dt, phi * dt}, eq.t + phi * dt); failed(bad)) return bad;
    drift_blocks<S>(eq.next, (1 - phi) * dt);
    eq.add_increment((1 - phi) / phi);
    return Eq::Rhs::is_finite(eq.next) ? Outcome::success : Outcome::non_finite_state;
  }

  [[no_unique_address]] Scheme scheme_;
};

/// Rannacher's start: the first step (or the first `pairs` steps) as two backward Euler half steps each, then the
/// trapezoidal rule. The half steps damp what the trapezoidal rule would let ring, a jump in the data say, at no cost in
/// order and with the same matrix. First means: since the stepper was made or reset.
struct Rannacher {
  static constexpr SchemeFacts facts = AStable{.is_l_stable = false, .energy = EnergyBalance::rest};
  int pairs = 1;  ///< of half steps: 1 for a jump in the data, 2 for a point source (Dirac's δ)

  [[nodiscard]] static constexpr const char* name() { return "rannacher"; }
  [[nodiscard]] static constexpr int order() { return 2; }
  /// @throws std::invalid_argument where n is negative
  [[nodiscard]] constexpr Rannacher operator()(int n) const {
    if (n < 0) throw std::invalid_argument("phistep: rannacher(n) needs n >= 0 pairs of half steps");
    return {n};
  }
};

/// The trapezoidal rule for data that jump: `rannacher`, or `rannacher(2)` for a point source.
inline constexpr Rannacher rannacher{};

template <State S>
class SchemeOn<Rannacher, S> : public SchemeDefaults {
  using Trapezoidal = SchemeOn<SinglePhi<FixedPhi<1, 2>>, S>;

 public:
  using Scalar = ScalarOf<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.solver = true};

  SchemeOn(Rannacher scheme, const auto& y) : scheme_{scheme}, trapezoidal_{trapezoidal, y} {}
  [[nodiscard]] static int order() { return Rannacher::order(); }

  /// Steps of the start that have become the state.
  using Progress = int;
  [[nodiscard]] Progress progress() const { return done_; }
  void resume(Progress done) { done_ = done; }
  void archive(auto& ar) {
    ar("done", done_);
    ar.check(0 <= done_ && done_ <= scheme_.pairs);
  }
  void reset() { done_ = 0; }
  void accepted() { done_ += done_ < scheme_.pairs; }

  [[nodiscard]] Outcome step(auto& eq) const {
    if (done_ >= scheme_.pairs) return trapezoidal_.step(eq);
    const Scalar half = eq.dt / 2;
    copy_blocks<S>(eq.next, eq.y);
    if (const Outcome bad = eq.resolve({half, half}, eq.t + half); failed(bad)) return bad;
    return eq.resolve({half, half}, eq.t + eq.dt);  // (8)
  }

 private:
  Rannacher scheme_;
  [[no_unique_address]] Trapezoidal trapezoidal_;
  int done_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
