/// @file
/// The simplest controller: one Δt for the whole run; its grid of times.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A run from t0 to t1, forward or backward. [time]
template <class Scalar>
struct TimeSpan {
  Scalar t0, t1;
};

struct FixedStepOptions {
  std::int64_t max_steps = std::int64_t{1} << 53;  ///< a run of more steps is refused before it starts
};

/// Δt for every step but perhaps the last.
struct FixedStep {
  double dt;  ///< [time] positive; where t1 < t0, of either sign
  FixedStepOptions options;
};

/// One Δt for the whole run: `integrate(stepper, state, {t0, t1}, fixed(dt))`.
/// @param dt       [time] finite and not 0, or the run ends with Outcome::invalid_step
/// @param options  .max_steps: 2⁵³ unless given
[[nodiscard]] constexpr FixedStep fixed(double dt, FixedStepOptions options = {}) { return {dt, options}; }

/// Steps of Δt over a span of the length T = t₁ − t₀, and the n+1 times of their ends: t₀ + nΔt, then t₁ itself. Time is
/// never a running sum, so it collects no error; and the remainder after whole steps is computed as T − nΔt, not from
/// times, so that a run far from t = 0 loses nothing of its motion.
template <class Scalar>
class TimeGrid {
 public:
  /// On a grid that can't be stepped, outcome() says why and steps() is 0.
  TimeGrid(TimeSpan<Scalar> span, const FixedStep& fixed) : span_{span}, dt_{static_cast<Scalar>(fixed.dt)} {
    const Scalar length = span.t1 - span.t0;
    if (!std::isfinite(length) || !std::isfinite(dt_) || dt_ == 0 || (dt_ < 0 && length > 0)) {
      outcome_ = Outcome::invalid_step;
      return;
    }
    if (length == 0) return;
    dt_ = std::copysign(dt_, length);
    const Scalar wanted = length / dt_;
    // However many are allowed: beyond 2⁵³ a step's number isn't one that a double has.
    const std::int64_t most = std::min(fixed.options.max_steps, FixedStepOptions{}.max_steps);
    if (!(wanted <= static_cast<Scalar>(most) + 1)) {
      outcome_ = Outcome::too_many_steps;
      return;
    }
    const Scalar tick = spacing(std::max(std::abs(span.t0), std::abs(span.t1)));
    if (std::abs(dt_) < tick) {
      outcome_ = Outcome::step_too_small;
      return;
    }
    share_out(length, std::floor(wanted), tick);
    if (steps_ > fixed.options.max_steps) {
      outcome_ = Outcome::too_many_steps;
      steps_ = 0;
    }
  }

  [[nodiscard]] Outcome outcome() const { return outcome_; }
  [[nodiscard]] std::int64_t steps() const { return steps_; }
  [[nodiscard]] Scalar time(std::int64_t n) const {
    return n >= steps_ ? span_.t1 : span_.t0 + static_cast<Scalar>(n) * dt_;
  }
  /// The length of step n (0-based).
  [[nodiscard]] Scalar step(std::int64_t n) const { return n + 1 == steps_ ? last_ : dt_; }
  /// The length from node n to t, however coarse the clock is: t − t₀ − nΔt.
  [[nodiscard]] Scalar from_node(std::int64_t n, Scalar t) const {
    return n >= steps_ ? t - span_.t1 : std::fma(static_cast<Scalar>(-n), dt_, t - span_.t0);
  }

 private:
  /// How many steps, and how long the last one is.
  void share_out(Scalar length, Scalar whole, Scalar tick) {
    const Scalar rest = std::fma(-whole, dt_, length);
    // Δt, t₁ and their difference are rounded: a rest of that size is none, and one that near to Δt is Δt (one factorization
    // a run).
    const Scalar rounding = 2 * std::numeric_limits<Scalar>::epsilon() * std::abs(length);
    steps_ = static_cast<std::int64_t>(whole);
    last_ = dt_;
    if (whole > 0 && std::abs(rest) <= rounding) return;
    // Up to the rounding of t₀ and t₁ the rest is added to the last step.
    const bool is_unseen = std::abs(rest) <= 2 * tick && std::abs(rest) <= std::abs(dt_) / 100;
    if (whole > 0 && is_unseen) {
      last_ = dt_ + rest;
      return;
    }
    ++steps_;
    if (std::abs(rest - dt_) > rounding) last_ = rest;
  }

  TimeSpan<Scalar> span_;
  Scalar dt_, last_{0};
  std::int64_t steps_ = 0;
  Outcome outcome_ = Outcome::success;
};

/// The times of the steps that one call of a stepper takes: here one step.
template <class Scalar>
struct OneStep {
  Scalar start, dt;  ///< [time]
  [[nodiscard]] static constexpr std::int64_t count() { return 1; }
  [[nodiscard]] Scalar t(std::int64_t) const { return start; }
};

/// The times of several steps of one length, from node to node of a grid t₀ + nΔt, none of them its last: their lengths and
/// times are known to be sound.
template <class Scalar>
struct GridSteps {
  Scalar t0, dt;              ///< [time]
  std::int64_t first, steps;  ///< the node where the first begins; how many there are
  [[nodiscard]] std::int64_t count() const { return steps; }
  [[nodiscard]] Scalar t(std::int64_t n) const { return t0 + static_cast<Scalar>(first + n) * dt; }
};

}}  // namespace phistep::PHISTEP_ABI
