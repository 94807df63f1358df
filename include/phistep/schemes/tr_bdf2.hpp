/// @file
/// TR-BDF2 (Bank, Coughran, Fichtner, Grosse, Rose & Smith, IEEE Trans. Electron Devices 32 (1985) 1992; Hosea & Shampine,
/// Appl. Numer. Math. 20 (1996) 21): the trapezoidal rule over γΔt, then BDF2 through y, Y and y⁺,
///
///     Y  = y + ½γΔt M⁻¹(Ψ(t, y) + Ψ(t+γΔt, Y))                                                                  (1)
///     y⁺ = Y/(γ(2−γ)) − y (1−γ)²/(γ(2−γ)) + (1−γ)/(2−γ) Δt M⁻¹Ψ(t+Δt, y⁺)                                       (2)
///
/// With γ = 2−√2 both resolves have the coefficient a = ½γΔt = (1−γ)/(2−γ) Δt, and so one matrix. The weights in (2) sum to
/// one: its explicit part is b = y + β (Y − y), β = 1/(γ(2−γ)) = (1+√2)/2, written so that rounding in the weights
/// multiplies an increment, not y. For motion, r obeys the same row with v in place of M⁻¹Ψ.
///
/// With ζ = ½γz, R(z) = (1 + √2 ζ)/(1 − ζ)² vanishes at infinity, and e^z − R = −0.0404 z³ + O(z⁴).
///
/// Ψ⁺ = M (y⁺ − b)/a is the next step's Ψ, without a call. An error e in ΔtΨ changes Y by ½γe/(1−ζ) and y⁺ by
/// β·½γe/(1−ζ)², and thus the next ΔtΨ⁺ = z y⁺ by βζe/(1−ζ)²: at most 0.61 e for every z that decays, 0.31 e for
/// real ones, nothing for stiff ones. It dies out, so the reuse needs no refreshing (at φ = ½ the factor is 1).
#pragma once

#include <numbers>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/step/kernel/scheme_on.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// TR-BDF2: the trapezoidal rule over γΔt, then the second backward difference formula to the end of the step, γ = 2−√2.
/// Order 2, L-stable: it damps what it can't resolve, and has half the trapezoidal rule's error at twice its solves.
struct TrBdf2 {
  static constexpr SchemeFacts facts = AStable{.is_l_stable = true, .energy = EnergyBalance::rest};
  [[nodiscard]] static constexpr const char* name() { return "tr_bdf2"; }
  [[nodiscard]] static constexpr int order() { return 2; }
};

/// Order 2 and L-stable, for stiff problems at few digits; two solves a step with one matrix.
inline constexpr TrBdf2 tr_bdf2{};

template <State S>
class SchemeOn<TrBdf2, S> : public SchemeDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.solver = true, .carries = can_carry<Rhs>};

  static constexpr Scalar gamma = Scalar{2} - std::numbers::sqrt2_v<Scalar>;
  static constexpr Scalar beta = (Scalar{1} + std::numbers::sqrt2_v<Scalar>) / 2;

  SchemeOn(TrBdf2, const Plain& y) : stage_{y} {}
  void resize(const Plain& y) { stage_ = y; }
  [[nodiscard]] static int order() { return TrBdf2::order(); }
  [[nodiscard]] static bool takes_singular_mass() { return true; }
  static constexpr bool traces = true;
  [[nodiscard]] static bool estimates(const auto&) { return true; }

  [[nodiscard]] Outcome step(auto& eq) {
    const Scalar dt = eq.dt, a = gamma / 2 * dt;
    const Gamma<Scalar> both{a, a};
    if (const Outcome bad = eq.check_start(both); failed(bad)) return bad;
    if (const Outcome bad = eq.forward({a, a, 0}); failed(bad)) return bad;
    eq.predict(gamma * dt);
    if (const Outcome bad = eq.resolve(both, eq.t + gamma * dt); failed(bad)) return bad;  // (1)
    copy_blocks<S>(stage_, eq.next);
    assign<S>(eq.next, in<S>(eq.y) + beta * (in<S>(stage_) - in<S>(eq.y)));
    eq.predict(dt);
    return eq.resolve(both, eq.t + dt, stage_);  // (2)
  }
  /// e = Δt [(4w−1)/3 y'(t) − 1/3 Y' + γ/3 y'⁺], w = √2/4: the difference to Hosea & Shampine's embedded formula of order 3.
  [[nodiscard]] static Outcome error(auto& eq) {
    constexpr Scalar w = std::numbers::sqrt2_v<Scalar> / 4;
    auto& trace = eq.trace;
    const auto start = in<S>(trace.start), middle = in<S>(trace.error), end = in<S>(trace.end);
    assign<S>(trace.error, eq.dt * ((4 * w - 1) / 3 * start - middle / Scalar{3} + gamma / 3 * end));
    trace.has_slopes = trace.has_error = true;
    eq.complete_start();
    return eq.filter(trace.error);
  }

  /// Y of the last step, at t + γΔt.
  [[nodiscard]] const Plain& stage() const { return stage_; }

 private:
  Plain stage_;
};

}}  // namespace phistep::PHISTEP_ABI
