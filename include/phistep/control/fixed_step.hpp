/// @file
/// The simplest controller: one Δt for the whole run.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "phistep/core/outcome.hpp"
#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// A run from t0 to t1, forward or backward. [time]
template <class Scalar>
struct TimeSpan {
  Scalar t0, t1;
};

struct FixedStepOptions {
  std::int64_t max_steps = std::int64_t{1} << 53;  ///< a run of more steps is refused before it starts
};

/// |Δt| for every step but perhaps the last.
struct FixedStep {
  double dt;  ///< [time] its sign is that of t1 − t0
  FixedStepOptions options;
};

/// `integrate(stepper, state, {t0, t1}, fixed(dt))`
[[nodiscard]] constexpr FixedStep fixed(double dt, FixedStepOptions options = {}) { return {dt, options}; }

/// The n+1 times of a run: t₀ + nΔt, then t₁ itself. Time is never a running sum, so it collects no error.
template <class Scalar>
class TimeGrid {
 public:
  /// On a grid that can't be stepped, outcome() says why and steps() is 0.
  TimeGrid(TimeSpan<Scalar> span, const FixedStep& fixed) : span_{span}, dt_{static_cast<Scalar>(fixed.dt)} {
    const Scalar length = span.t1 - span.t0;
    if (!std::isfinite(length) || !std::isfinite(dt_) || dt_ == Scalar{0}) {
      outcome_ = Outcome::invalid_step;
      return;
    }
    if (length == Scalar{0}) return;
    dt_ = std::copysign(dt_, length);
    const Scalar wanted = length / dt_;
    // However many are allowed: beyond 2⁵³ a step's number isn't one that a double has.
    const std::int64_t most = std::min(fixed.options.max_steps, FixedStepOptions{}.max_steps);
    if (!(wanted <= static_cast<Scalar>(most) + 1)) {
      outcome_ = Outcome::too_many_steps;
      return;
    }
    steps_ = static_cast<std::int64_t>(std::floor(wanted));
    // What is left over after whole steps: nothing but rounding keeps the nominal Δt (one factorisation a run).
    const Scalar rest = span.t1 - (span.t0 + static_cast<Scalar>(steps_) * dt_);
    const Scalar rounding =
        8 * std::numeric_limits<Scalar>::epsilon() * (std::abs(span.t0) + std::abs(span.t1) + std::abs(dt_));
    if (steps_ == 0 || std::abs(rest) > rounding) {
      ++steps_;
      if (std::abs(std::abs(rest) - std::abs(dt_)) > rounding) last_ = rest;
    }
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
  [[nodiscard]] Scalar step(std::int64_t n) const { return n + 1 == steps_ && last_ != Scalar{0} ? last_ : dt_; }

 private:
  TimeSpan<Scalar> span_;
  Scalar dt_;
  Scalar last_{0};  // length of a shorter last step; 0 where it isn't shorter
  std::int64_t steps_ = 0;
  Outcome outcome_ = Outcome::success;
};

}  // namespace phistep::inline PHISTEP_ABI
