/// @file
/// What a step tells of itself beside its end: the seam between steppers, which fill it, and controllers, predictors and
/// dense output, which read it. Steps without these have none.
#pragma once

#include <cmath>

#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/reductions.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Whether the force is smooth over a step, by the estimates of the tries before it: ‖e‖ of a smooth one goes as Δt^k, that of
/// one with a jump inside as Δt at most. An estimate may miss the jump, because its weights cancel at the stages before it;
/// that it has not fallen since the last try as Δt^k does shows wherever the jump is.
class Smoothness {
 public:
  /// False where ‖e‖ has grown too much beyond Δt^k since the last smooth try.
  /// @param square  of ‖e‖   @param dt  [time] Δt   @param k  the power of Δt in ‖e‖
  [[nodiscard]] bool holds(double square, double dt, int k) {
    now_ = {square, std::abs(dt)};
    // Steps that follow each other may meet a force that changes fast; those that start from one point meet the same.
    const double most = is_retry_ ? 8 : 300;
    const double allowed = before_.square * most * most;
    const bool smooth = !(before_.square > 0) || (square <= allowed && now_.dt >= before_.dt) ||
                        square <= allowed * power(now_.dt / before_.dt, 2 * k);
    if (smooth) before_ = now_;
    is_retry_ = true;
    return smooth;
  }
  /// The last try has become a step.
  void accepted() {
    before_ = now_;
    is_retry_ = false;
  }
  void forget() { *this = {}; }
  void archive(auto& ar) {
    ar("square", now_.square, "dt", now_.dt);
    ar.check(now_.square >= 0 && now_.dt >= 0);
    before_ = now_;
  }

 private:
  struct Try {
    double square = 0;  ///< of ‖e‖; 0: nothing is known
    double dt = 0;      ///< [time]
  };
  Try before_, now_;
  bool is_retry_ = false;
};

/// |Δt y'/y⁺| of what begins in a damped step is this at most.
inline constexpr int most_power = 64;

/// @tparam Plain  the owning state; every member is shaped like it
template <State Plain>
struct Trace {
  using Scalar = ScalarOf<Plain>;

  // Written by the controller before the step.
  Plain weight;                  ///< 1/(atol + rtol |y|): what a component's error is multiplied by
  double rtol = 0;               ///< the one in `weight`
  double newton_target = 0;      ///< weighted RMS of the error that an implicit solve may leave; 0: its options rule
  const Plain* usual = nullptr;  ///< usual sizes of components, for differences; null: those that the weights give
  bool weighs_most = false;      ///< by these weights no error is less than the run finds it
  bool has_unsized = false;      ///< components whose weight is 0 are measured by what they become
  bool wants_dense = false;      ///< dense output is read: keep what interpolate() needs
  bool asks_end = false;         ///< the step ends where the run does, or stops: Ψ there is asked in any case

  // Carried from step to step. After an edit of the state, or of a step rejected after it was accepted: forget().
  bool knows_start = false;  ///< `start` holds y' where the next step starts
  Scalar dt_before{0};       ///< [time] length of the step before, 0: there was none
  Plain before;              ///< y' where that step started

  // Written by the step. Slopes by the scheme's own relations, not by force calls: stiff components keep their digits.
  Plain start;                    ///< y' at t (for motion: v, M⁻¹Ψ)
  Plain end;                      ///< y' at t + Δt
  Scalar dt{0};                   ///< [time] Δt
  Plain error;                    ///< the estimate of the local error, but for a factor
  double error_scale_square = 1;  ///< the square of that factor
  bool has_slopes = false;        ///< `start` and `end` are filled
  bool has_error = false;         ///< `error` is filled
  const Plain* rate = nullptr;    ///< y' at the end, where something began that had no size; null: not known
  bool has_hidden = false;        ///< rates fell in the last try: where slopes lead is not known
  bool has_met_bound = false;     ///< a solve of this run has met a place where Ψ doesn't exist
  Smoothness smoothness;          ///< of the force, by the estimates of explicit pairs
  double proposed = 0;  ///< [time] |Δt| that a step which chooses it itself wants next, accepted or not; 0: it doesn't

  Plain predicted;  ///< scratch: where an implicit solve may start

  /// Shaped like y.
  void resize(const Plain& y) {
    for (Plain* x : {&weight, &before, &start, &end, &error, &predicted}) {
      *x = y;
      set_zero(Blocks<Plain>::all(*x));
    }
    forget();
  }
  /// The next step starts somewhere else.
  void forget() {
    smoothness.forget();
    has_hidden = false;
    forget_slopes();
  }
  /// The slope where the next step starts isn't known.
  void forget_slopes() {
    knows_start = has_slopes = has_error = false;
    dt_before = Scalar{0};
    proposed = 0;
  }
  /// The step has become the state.
  void advance() {
    smoothness.accepted();
    has_hidden = false;
    if (!has_slopes) return forget_slopes();
    for_each_block(
        [](auto, auto& a, auto& b, auto& c) {
          if constexpr (std::remove_cvref_t<decltype(a)>::SizeAtCompileTime != Eigen::Dynamic) a = b, b = c;
          else a.swap(b), b.swap(c);
        },
        Blocks<Plain>::all(before), Blocks<Plain>::all(start), Blocks<Plain>::all(end));
    dt_before = dt;
    knows_start = true;
    has_slopes = has_error = false;
  }
  /// The state is again what it was before the last advance().
  void step_back() {
    if (!knows_start) return;
    for_each_block([](auto, auto& a, auto& b) { a.swap(b); }, Blocks<Plain>::all(before), Blocks<Plain>::all(start));
    dt_before = Scalar{0};
    has_slopes = has_error = false;
  }

  void archive(auto& ar) {
    ar("knows_start", knows_start, "dt_before", dt_before, "smoothness", smoothness, "has_met_bound", has_met_bound);
    ar.check(std::isfinite(dt_before));
    if (knows_start || dt_before != 0) ar.in_place("before", before, "start", start);
    if (knows_start) ar.check(!first_non_finite(Blocks<Plain>::all(start)));
    if (dt_before != 0) ar.check(!first_non_finite(Blocks<Plain>::all(before)));
  }
};

/// What a run thinks of a step, by reference: whether it may become the state, and how large errors are in units of the tolerance.
/// One type for all runs, so that a scheme's step is compiled once.
template <State Plain>
class Judge {
 public:
  /// @param law  (y, y⁺, trace) → whether the step may become the state; with sizes of its own, allowed() → how large an error may be,
  ///             size(x, y, y⁺) → ‖x‖ and size_of_error(y, y⁺, trace) → ‖trace.error‖, else the weighted RMS serves
  template <class Given>
    requires(!std::is_same_v<std::remove_cvref_t<Given>, Judge>)
  Judge(Given&& law) : law_{const_cast<std::remove_cvref_t<Given>*>(&law)} {
    using Law = std::remove_reference_t<Given>;
    accepts_ = [](void* by, const Plain& y, const Plain& next, const Trace<Plain>& trace) -> bool {
      return (*static_cast<Law*>(by))(y, next, trace);
    };
    if constexpr (requires { law.allowed(); }) {
      allowed_ = [](void* by) { return static_cast<Law*>(by)->allowed(); };
      size_ = [](void* by, const Plain& x, const Plain& y, const Plain& next) {
        return static_cast<Law*>(by)->size(x, y, next);
      };
      size_of_error_ = [](void* by, const Plain& y, const Plain& next, const Trace<Plain>& trace) {
        return static_cast<Law*>(by)->size_of_error(y, next, trace);
      };
    }
  }
  [[nodiscard]] bool operator()(const Plain& y, const Plain& next, const Trace<Plain>& trace) const {
    return accepts_(law_, y, next, trace);
  }
  [[nodiscard]] bool has_sizes() const { return allowed_ != nullptr; }
  [[nodiscard]] double allowed() const { return allowed_(law_); }
  [[nodiscard]] double size(const Plain& x, const Plain& y, const Plain& next, const Trace<Plain>& trace) const {
    return has_sizes() ? size_(law_, x, y, next) : weighted_rms(x, trace.weight);
  }
  [[nodiscard]] double size_at_most(const Plain& x, const Plain& y, const Plain& next,
                                    const Trace<Plain>& trace) const {
    return trace.weighs_most ? weighted_rms(x, trace.weight) : size(x, y, next, trace);
  }
  [[nodiscard]] double size_of_error(const Plain& y, const Plain& next, const Trace<Plain>& trace) const {
    return has_sizes() ? size_of_error_(law_, y, next, trace) : weighted_rms(trace.error, trace.weight);
  }

 private:
  void* law_;
  bool (*accepts_)(void*, const Plain&, const Plain&, const Trace<Plain>&) = nullptr;
  double (*allowed_)(void*) = nullptr;
  double (*size_)(void*, const Plain&, const Plain&, const Plain&) = nullptr;
  double (*size_of_error_)(void*, const Plain&, const Plain&, const Trace<Plain>&) = nullptr;
};

/// Δt³/12 y‴, the trapezoidal rule's y⁺ − y(t+Δt), times a factor, as an expression. y‴ is the second difference of three
/// slopes.
template <State Plain>
[[nodiscard]] auto milne(const Trace<Plain>& trace, ScalarOf<Plain> dt, ScalarOf<Plain> factor = 1) {
  const auto end = in<Plain>(trace.end), start = in<Plain>(trace.start), before = in<Plain>(trace.before);
  const auto rho = dt / trace.dt_before;
  return factor * dt / (6 * (1 + 1 / rho)) * ((end - start) - rho * (start - before));
}

}}  // namespace phistep::PHISTEP_ABI
