/// @file
/// Generalized-α (J. Chung & G. M. Hulbert, J. Appl. Mech. 60 (1993) 371): Newmark's formulas with an acceleration a of their
/// own, which the forces of both ends rule by a weighted balance,
///
///     r⁺ = r + Δt v + Δt² ((½−β) a + β a⁺)                                                                      (1)
///     v⁺ = v + Δt ((1−γ) a + γ a⁺)                                                                              (2)
///     (1−α_m) a⁺ + α_m a = (1−α_f) k⁺ + α_f k,      k = M⁻¹Ψ(t, r, v)                                           (3)
///
/// of order 2 where γ = ½ + s, s = α_f − α_m; with β = ¼(1+s)² what is too fast for Δt is damped most (eqs. 17, 20, 25):
///
///     ρ∞        α_m = (2ρ−1)/(1+ρ),   α_f = ρ/(1+ρ):   high modes shrink by ρ∞ a step, low ones least             (4)
///     HHT       α_m = 0,  α_f = −α   (H. M. Hilber, T. J. R. Hughes & R. L. Taylor, EESD 5 (1977) 283)            (5)
///     Bossak    α_f = 0,  α_m = α    (W. L. Wood, M. Bossak & O. C. Zienkiewicz, IJNME 15 (1980) 1562)            (6)
///     Newmark   α_m = α_f = 0, β and γ given   (N. M. Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67)              (7)
///
/// y' = Ψ has (2) and (3) with α_m = ½(3ρ−1)/(1+ρ), α_f = ρ/(1+ρ), γ = ½ + s (K. E. Jansen, C. H. Whiting & G. M. Hulbert,
/// CMAME 190 (2000) 305, whose α's weigh the new end). ρ∞ = 1 is the trapezoidal rule. (3) in (2), c = γ/(1−α_m), and (2)
/// in (1) are a resolve:
///
///     b.v = v + Δt ((1−c) a + c α_f k),   b.r = r + Δt (1−β/γ) v + Δt² (½−β/γ) a                                 (8)
///     v⁺ = b.v + (1−α_f) c Δt k⁺,         r⁺ = b.r + (β/γ) Δt v⁺                                                 (9)
///
/// By (3), a is the acceleration at t − sΔt. So where Δt changes to Δt', a ← a − s(Δt'−Δt)(a⁺−a)/Δt; without that the order
/// is 1. By no more than for Δt' = 10Δt under a tolerance: where a share q of s Δt' is missing so, a is off by q s (k⁺−k), and by
/// (3) v, in this step and those that follow, by (½−α_f) Δt times that: O(Δt²) once. Without one, a step longer than 2Δt is a start:
/// high modes would grow where Δt changes fivefold to and fro. A start, and what follows an edit or a jump, knows k alone. It is a step of the
/// trapezoidal rule, s = 0, which adds no energy to any mode, and whose way gives a⁺ = k⁺ − s(k⁺−k). In all
///
///     r⁺ − r(t+Δt) = (β − s/2 − 1/6) Δt³ r‴                                                                     (10)
///     v⁺ − v(t+Δt) = (1/12 − s²/2 + ½α_f(1−α_f) − ½α_m(1−α_m)) Δt³ v‴ + (γ−½−s + (½−α_f) q s) Δt (k⁺−k)         (11)
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <stdexcept>
#include <utility>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/kernel/scheme_on.hpp"
#include "phistep/step/transaction/edit_guard.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The weights of (1) to (3); α_m and α_f are those of the old end.
struct AlphaWeights {
  double alpha_m = 0, alpha_f = 0, beta = 0.25, gamma = 0.5;
  /// γ and β for order 2 and most damping.
  [[nodiscard]] static constexpr AlphaWeights of(double alpha_m, double alpha_f) {
    const double s = alpha_f - alpha_m;
    return {alpha_m, alpha_f, (1 + s) * (1 + s) / 4, 0.5 + s};
  }
  [[nodiscard]] constexpr double lag() const { return alpha_f - alpha_m; }  ///< s: a belongs to t − sΔt
};

/// Generalized-α of one number: order 2, A-stable, and modes that Δt can't resolve shrink by the factor ρ∞ each step.
struct GeneralizedAlpha {
  static constexpr SchemeFacts facts = AStable{.is_l_stable = false, .energy = EnergyBalance::rest};
  double rho;  ///< ρ∞
  [[nodiscard]] static constexpr const char* name() { return "generalized_alpha"; }
  [[nodiscard]] static constexpr int order() { return 2; }
  [[nodiscard]] constexpr AlphaWeights weights(bool is_motion) const {
    const double f = rho / (1 + rho);
    return AlphaWeights::of(is_motion ? (2 * rho - 1) / (1 + rho) : (3 * rho - 1) / (2 + 2 * rho), f);
  }
};
/// Newmark's method and its relatives of one parameter, for motion.
struct NewmarkAlpha {
  static constexpr SchemeFacts facts{.motion_only = true,
                                     .is_explicit = false,
                                     .is_symplectic = false,
                                     .is_a_stable = false,  // not of each β and γ
                                     .is_l_stable = false,
                                     .energy = EnergyBalance::rest};
  AlphaWeights given;
  [[nodiscard]] static constexpr const char* name() { return "newmark"; }
  [[nodiscard]] constexpr int order() const { return std::abs(given.gamma - given.lag() - 0.5) < 1e-12 ? 2 : 1; }
  [[nodiscard]] constexpr AlphaWeights weights(bool /*is_motion*/) const { return given; }
};

/// Order 2 and damping: from ρ∞ = 1, the trapezoidal rule, to 0, which leaves nothing of what Δt can't resolve. (4)
/// @throws std::invalid_argument unless 0 ≤ rho_inf ≤ 1
[[nodiscard]] constexpr GeneralizedAlpha generalized_alpha(double rho_inf) {
  if (!(rho_inf >= 0 && rho_inf <= 1))
    throw std::invalid_argument("phistep: the spectral radius at infinity must lie in [0, 1]");
  return {rho_inf};
}
/// (7); order 2 where gamma is ½, stable at any Δt where 2 beta ≥ gamma.
/// @throws std::invalid_argument unless beta > 0 and gamma ≥ ½: below, every vibration grows
[[nodiscard]] inline NewmarkAlpha newmark(double beta, double gamma) {
  if (!(beta > 0 && gamma >= 0.5 && std::isfinite(beta) && std::isfinite(gamma)))
    throw std::invalid_argument(
        "phistep: newmark(beta, gamma) needs beta > 0 and gamma >= 1/2 (beta = 0 is velocity_verlet)");
  return {{0, 0, beta, gamma}};
}
/// (5), with the authors' sign: M a⁺ + (1+α) K r⁺ − α K r = …; ρ∞ = (1+α)/(1−α).
/// @throws std::invalid_argument unless −1/3 ≤ alpha ≤ 0
[[nodiscard]] constexpr NewmarkAlpha hht(double alpha) {
  if (!(alpha >= -1.0 / 3 - 1e-15 && alpha <= 0))
    throw std::invalid_argument("phistep: hht(alpha) needs -1/3 <= alpha <= 0 (codes that take 0 to 1/3 mean -alpha)");
  return {AlphaWeights::of(0, -alpha)};
}
/// (6), with the authors' sign: (1−α) M a⁺ + α M a + K r⁺ = …; ρ∞ = (1+α)/(1−α).
/// @throws std::invalid_argument unless −1 ≤ alpha ≤ 0
[[nodiscard]] constexpr NewmarkAlpha bossak(double alpha) {
  if (!(alpha >= -1 && alpha <= 0)) throw std::invalid_argument("phistep: bossak(alpha) needs -1 <= alpha <= 0");
  return {AlphaWeights::of(alpha, 0)};
}

template <class Scheme>
concept HasAlphaWeights = requires(const Scheme& scheme) {
  { scheme.weights(true) } -> std::same_as<AlphaWeights>;
};
/// Steps by (1) to (3) of the file's head.
template <HasAlphaWeights Scheme, State S>
class SchemeOn<Scheme, S> : public SchemeDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.solver = true};
  static constexpr bool traces = true, looks_back = true;

  SchemeOn(Scheme scheme, const Plain& y) : scheme_{scheme}, w_{scheme.weights(Blocks<S>::drifts)}, used_{w_} {
    resize(y);
  }
  void resize(const Plain& y) {
    for (Known* known : {&now_, &next_}) {
      known->a = known->k = known->change = make_rate<S>(y);
      known->guard.reserve(y);
      known->guard.forget();
    }
    is_known_ = false;
  }
  [[nodiscard]] int order() const { return scheme_.order(); }
  [[nodiscard]] static bool estimates(const auto& trace) { return trace.dt_before != 0; }
  /// Whether the last step's end serves: where a step is taken back, what is known at its start does.
  using Progress = bool;
  [[nodiscard]] Progress progress() const { return is_known_; }
  void resume(Progress known) { is_known_ = known; }
  void forget() { is_known_ = false; }
  void accepted() {
    std::swap(now_, next_);
    is_known_ = true;
  }
  void archive(auto& ar) {
    ar("known", is_known_);
    if (!is_known_) return;
    ar("t", now_.t, "dt", now_.dt, "at", now_.guard);
    ar.in_place("a", now_.a, "k", now_.k, "change", now_.change);
    next_.guard.forget();
  }
  /// M⁻¹Ψ at the end of the last step, of order 2 as r and v are.
  [[nodiscard]] const Rate& slope() const { return now_.k; }
  /// a there, which is late by s Δt.
  [[nodiscard]] const Rate& a() const { return now_.a; }

  template <class Eq>
  [[nodiscard]] Outcome step(Eq& eq) {
    if (const Outcome bad = begin(eq); failed(bad)) return bad;
    const Scalar h = eq.dt, c = w(used_.gamma / (1 - used_.alpha_m)), f = w(used_.alpha_f),
                 drift = w(used_.beta / used_.gamma);
    const Gamma<Scalar> gamma{(1 - f) * c * h, drift * h};
    Rate &a = next_.a, &k = next_.k;
    assign_solved<S>(eq.next, in<S>(eq.y) + h * ((1 - c) * in_rate<S>(a) + (c * f) * in_rate<S>(k)));  // (8)
    if constexpr (Blocks<S>::drifts)
      position_of<S>(eq.next) = position_of<S>(eq.y) + (h * (1 - drift)) * velocity_of<S>(eq.y) +
                                (h * h * (Scalar{0.5} - drift)) * std::get<0>(Rate::blocks(a));
    eq.predict(h);
    if (const Outcome bad = eq.resolve(gamma, eq.t + h); failed(bad)) return bad;  // (9)
    Rate& change = next_.change;
    eq.slope_at_end(change);
    assign_rate<S>(k,
                   ((1 - f) * in_rate<S>(change) + f * in_rate<S>(k) - in_rate<S>(a)) / w(1 - used_.alpha_m));  // (3)
    std::swap(k, change);
    assign_rate<S>(a, in_rate<S>(a) + w(1 + used_.lag() - w_.lag()) * in_rate<S>(change));
    next_.t = eq.rhs().inside(eq.t + h);
    next_.dt = h;
    next_.guard.remember(next_.t, eq.next);
    return Outcome::success;
  }
  /// (10) and (11)
  [[nodiscard]] Outcome error(auto& eq) const {
    auto& trace = eq.trace;
    trace.has_slopes = true;
    trace.has_error = estimates(trace);
    if (!trace.has_error) return Outcome::success;
    const double s = used_.lag(), m = used_.alpha_m, f = used_.alpha_f,
                 third = 1.0 / 12 - s * s / 2 + (f * (1 - f) - m * (1 - m)) / 2,
                 first = used_.gamma - 0.5 - s + (0.5 - f) * s * missing_;
    assign<S>(trace.error, milne(trace, eq.dt, w(12 * (used_.beta - s / 2 - 1.0 / 6))));
    assign_solved<S>(trace.error,
                     milne(trace, eq.dt, w(12 * third)) + (w(first) * eq.dt) * (in<S>(trace.end) - in<S>(trace.start)));
    return eq.filter(trace.error);
  }

 private:
  /// At a step's end.
  struct Known {
    Rate a, k;                         ///< [force/mass]
    Rate change;                       ///< a⁺ − a of that step
    Scalar t{}, dt{};                  ///< [time]
    EditGuard<S, false, false> guard;  ///< of the state there
  };
  [[nodiscard]] static Scalar w(double weight) { return static_cast<Scalar>(weight); }
  /// Whether that is where the step starts; a field that was put back is another one. (A run under a tolerance tries steps from
  /// states that are some roundings off: there, its trace decides.)
  template <class Eq>
  [[nodiscard]] static bool is_at(const Known& known, const Eq& eq) {
    if constexpr (Eq::Rhs::uses_time)
      if (!same_time<true>(eq.rhs().inside(eq.t), known.t)) return false;
    return known.guard.holds(known.t, eq.y);
  }
  /// next = a and k at the start: those of the last step's end, a moved to where it belongs, or both from a force call.
  template <class Eq>
  [[nodiscard]] Outcome begin(Eq& eq) {
    bool goes_on = is_known_ && w_.alpha_f < 0.5;  // at α_f = ½ errors in the k kept would not die out
    if constexpr (Eq::is_traced) goes_on = goes_on && (eq.trace.dt_before != 0 || finds(eq));
    else goes_on = goes_on && finds(eq);
    next_.guard.forget();
    if (!is_known_) now_.guard.forget();
    if constexpr (Eq::is_traced)
      if (const Outcome bad = eq.start(); failed(bad)) return bad;
    if (can_carry<typename Eq::Rhs> && goes_on) {
      next_.k = now_.k;
    } else {
      if (const Outcome bad = eq.slope_at_start(next_.k); failed(bad)) return bad;
      if (!all_finite(Rate::blocks(std::as_const(next_.k)))) {
        eq.psi = next_.k;
        copy_blocks<S>(eq.next, eq.y);  // kept for the failure message
        return Outcome::non_finite_force;
      }
    }
    if (goes_on && w_.lag() != 0 && (Eq::is_traced || std::abs(eq.dt) <= 2 * std::abs(now_.dt))) {
      used_ = w_;
      const Scalar most = 10, ratio = eq.dt / now_.dt, moved = std::clamp(ratio, -most, most);
      missing_ = static_cast<double>((ratio - moved) / ratio);
      assign_rate<S>(next_.a, in_rate<S>(now_.a) - (w(w_.lag()) * (moved - 1)) * in_rate<S>(now_.change));
    } else {
      if (w_.lag() != 0) used_ = {};
      missing_ = 0;
      next_.a = next_.k;
    }
    return Outcome::success;
  }
  /// Whether anything is known where the step starts; `now_` is then that.
  [[nodiscard]] bool finds(const auto& eq) {
    if (is_at(now_, eq)) return true;
    if (!is_at(next_, eq)) return false;
    std::swap(now_, next_);
    return true;
  }

  [[no_unique_address]] Scheme scheme_;
  AlphaWeights w_, used_;  // those of the scheme, of the step under way
  Known now_, next_;       // now_: at the last step's end; next_: at that under way's, else the last one's start
  bool is_known_ = false;
  double missing_ = 0;  // q in (11), of the step under way
};

}}  // namespace phistep::PHISTEP_ABI
