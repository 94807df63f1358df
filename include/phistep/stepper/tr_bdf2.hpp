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

#include "phistep/core/outcome.hpp"
#include "phistep/core/phi.hpp"
#include "phistep/core/version.hpp"
#include "phistep/resolve/dense_system.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/stepper/error_estimate.hpp"
#include "phistep/stepper/kernel.hpp"

namespace phistep::inline PHISTEP_ABI {

template <State S>
class Row<TrBdf2, S> : public RowDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.solver = true, .carries = can_carry<Rhs>};

  static constexpr Scalar gamma = Scalar{2} - std::numbers::sqrt2_v<Scalar>;
  static constexpr Scalar beta = (Scalar{1} + std::numbers::sqrt2_v<Scalar>) / 2;

  Row(TrBdf2, const Plain& y) : base_{y}, stage_{y} {}
  void resize(const Plain& y) { base_ = stage_ = y; }
  [[nodiscard]] static int order() { return TrBdf2::order(); }

  template <class Kernel>
  [[nodiscard]] Outcome advance(Kernel& kernel, typename Kernel::Data& step) {
    const Scalar a = gamma / 2 * step.dt;
    const Gamma<Scalar> both{a, a};
    if (const Outcome outcome = kernel.forward(step, {a, a, 0}); outcome != Outcome::success) return outcome;
    copy_blocks<S>(base_, step.next);
    if (const Outcome outcome = kernel.resolve(step, both, step.t + gamma * step.dt); outcome != Outcome::success)
      return outcome;  // (1)
    copy_blocks<S>(stage_, step.next);
    for_each_block([](auto, auto& b, const auto& y, const auto& Y) { b = y + beta * (Y - y); },
                   Blocks<S>::all(step.next), Blocks<S>::all(step.y), Blocks<S>::all(stage_));
    const Outcome outcome = kernel.resolve(step, both, step.t + step.dt, stage_);  // (2)
    if constexpr (Kernel::carries)
      if (outcome == Outcome::success) {
        kernel.recover(step, both);
        step.psi_next_known = true;
      }
    return outcome;
  }

  static constexpr bool traces = true;
  [[nodiscard]] static bool estimates(const auto&) { return true; }

  /// The same with both slopes and Hosea & Shampine's estimate: the difference to the embedded formula of order 3,
  /// e = Δt [(4w−1)/3 y'(t) − 1/3 Y' + γ/3 y'⁺], w = √2/4.
  template <class Kernel>
  [[nodiscard]] Outcome trace(Kernel& kernel, typename Kernel::Data& step) {
    const Scalar a = gamma / 2 * step.dt, w = std::numbers::sqrt2_v<Scalar> / 4;
    const Gamma<Scalar> both{a, a};
    auto& trace = *step.trace;
    if (const Outcome outcome = kernel.start(step); outcome != Outcome::success) return outcome;
    kernel.move(step, a);
    copy_blocks<S>(base_, step.next);
    const bool has_past = trace.dt_before != 0;
    if (has_past) predict(trace, step.y, gamma * step.dt);
    if (const Outcome outcome = kernel.resolve_predicted(step, both, step.t + gamma * step.dt, base_, has_past);
        outcome != Outcome::success)
      return outcome;  // (1)
    copy_blocks<S>(stage_, step.next);
    // The parabola through y, y' and Y' predicts y⁺ = y + Δt [y' + (Y' − y')/(2γ)]; before the first step, y' may be that
    // of a transient.
    for_each_block(
        [a, has_past, dt = step.dt](auto, auto& predicted, auto& error, auto& b, const auto& base, const auto& y,
                                    const auto& Y, const auto& start) {
          error = (Y - base) / a;  // Y'
          if (has_past) predicted = y + dt * (start + (error - start) / (2 * gamma));
          else predicted = Y;
          b = y + beta * (Y - y);
        },
        Blocks<S>::all(trace.predicted), Blocks<S>::all(trace.error), Blocks<S>::all(step.next), Blocks<S>::all(base_),
        Blocks<S>::all(step.y), Blocks<S>::all(stage_), Blocks<S>::all(trace.start));
    copy_blocks<S>(trace.end, step.next);  // b
    if (const Outcome outcome = kernel.resolve_predicted(step, both, step.t + step.dt, trace.end, true);
        outcome != Outcome::success)
      return outcome;  // (2)
    for_each_block(
        [=, dt = step.dt](auto, auto& end, auto& e, const auto& next, const auto& start) {
          end = (next - end) / a;
          e = dt * ((4 * w - 1) / 3 * start - e / 3 + gamma / 3 * end);
        },
        Blocks<S>::all(trace.end), Blocks<S>::all(trace.error), Blocks<S>::all(step.next), Blocks<S>::all(trace.start));
    trace.has_slopes = trace.has_error = true;
    return kernel.filter(trace.error);
  }

  /// y + a M⁻¹Ψ(t, y) of the last step. With stage() = Y and b as above, the three slopes M⁻¹Ψ, each times a, are
  /// base − y, Y − base and y⁺ − b: all that an embedded estimate needs, for every block alike.
  [[nodiscard]] const Plain& base() const { return base_; }
  /// Y of the last step, at t + γΔt.
  [[nodiscard]] const Plain& stage() const { return stage_; }

 private:
  Plain base_, stage_;
};

}  // namespace phistep::inline PHISTEP_ABI
