/// @file
/// The simplest controller: one Δt for the whole run; its grid of times, and the pace of runs on it. And what one call of a stepper
/// takes (Transaction::run): OneStep, GridSteps.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/run/control/run_clock.hpp"
#include "phistep/run/control/run_report.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

/// Steps of Δt over a span of the length T = t₁ − t₀, whatever stops and events lie in between, and the n+1 times of their ends:
/// t₀ + nΔt, then t₁ itself. Time is never a running sum, so it collects no error; and the remainder after whole steps is
/// computed as T − nΔt, not from times, so that a run far from t = 0 loses nothing of its motion.
template <class Scalar>
class GridPace {
 public:
  static constexpr bool sees_error = false, varies = false;

  explicit GridPace(const FixedStep& control) : control_{control} {}
  /// On a grid that can't be stepped, steps() is 0.
  [[nodiscard]] Outcome begin(TimeSpan<Scalar> span) {
    span_ = span;
    node_ = span.t0;
    done_ = steps_ = 0;
    dt_ = static_cast<Scalar>(control_.dt);
    const Scalar length = span.t1 - span.t0;
    if (!std::isfinite(length) || !std::isfinite(dt_) || dt_ == 0 || (dt_ < 0 && length > 0))
      return Outcome::invalid_step;
    if (length == 0) return Outcome::success;
    dt_ = std::copysign(dt_, length);
    const Scalar wanted = length / dt_;
    // However many are allowed: beyond 2⁵³ a step's number isn't one that a double has.
    const std::int64_t most = std::min(control_.options.max_steps, FixedStepOptions{}.max_steps);
    if (!(wanted <= static_cast<Scalar>(most) + 1)) return Outcome::too_many_steps;
    const Scalar tick = spacing(std::max(std::abs(span.t0), std::abs(span.t1)));
    if (std::abs(dt_) < tick) return Outcome::step_too_small;
    share_out(length, std::floor(wanted), tick);
    if (steps_ <= control_.options.max_steps) return Outcome::success;
    steps_ = 0;
    return Outcome::too_many_steps;
  }
  [[nodiscard]] std::int64_t steps() const { return steps_; }
  [[nodiscard]] Scalar time(std::int64_t n) const {
    return n >= steps_ ? span_.t1 : span_.t0 + static_cast<Scalar>(n) * dt_;
  }
  /// The length of step n (0-based).
  [[nodiscard]] Scalar step(std::int64_t n) const { return n + 1 == steps_ ? last_ : dt_; }
  [[nodiscard]] Refused refused() const { return {"dt", control_.dt}; }
  /// Whether the clock can tell an event from the next step's: Δt is 64 of its ticks at least.
  [[nodiscard]] bool suits_events(const RunClock<Scalar>& clock) const {
    const auto [t0, t1] = clock.span();
    return t0 == t1 ||
           !(std::abs(control_.dt) < 64 * static_cast<double>(spacing(std::max(std::abs(t0), std::abs(t1)))));
  }
  /// To the next node, or to a stop before it.
  [[nodiscard]] Landing<Scalar> plan(const RunClock<Scalar>& clock, std::optional<Scalar> stop) const {
    const Scalar node = time(done_ + 1), t = clock.t();
    // A stop that rounding alone keeps from a node is that node, unless that is the end.
    const Scalar beyond = stop ? clock.sign() * (node - *stop) : Scalar{-1};
    const Scalar same = node == clock.span().t1 ? Scalar{0} : clock.rounding(node);
    if (beyond > same) return {.end = *stop, .dt = length(t, *stop), .lands = true, .clipped = true, .at_stop = true};
    // From node to node Δt is the nominal one: their times differ by that only up to rounding.
    const Scalar whole = t == node_ ? step(done_) : -from_node(done_ + 1, t);
    const bool is_stop = stop && -beyond <= same;
    return {.end = is_stop ? *stop : node,
            .dt = whole,
            .lands = true,
            .clipped = false,
            .is_node = true,
            .at_stop = is_stop || node == clock.span().t1};
  }
  /// The steps of equal length ahead; none unless the run stands exactly at a node of the grid.
  [[nodiscard]] GridSteps<Scalar> ahead(const RunClock<Scalar>& clock) const {
    const bool at_node = clock.t() == time(done_);
    return {clock.span().t0, step(0), done_, at_node ? std::max<std::int64_t>(steps_ - 1 - done_, 0) : 0};
  }
  /// Where the first n of them end.
  [[nodiscard]] Landing<Scalar> after(std::int64_t n) const {
    return {time(done_ + n), step(done_), true, false, true, n};
  }
  /// The length from t to a stop before the next node.
  [[nodiscard]] Scalar length(Scalar t, Scalar stop) const { return t == node_ ? from_node(done_, stop) : stop - t; }
  [[nodiscard]] bool is_at_end(const RunClock<Scalar>&) const { return done_ >= steps_; }
  [[nodiscard]] static bool may_try() { return true; }
  /// The step has become the state. A node is reached at its own time or at one that is the same up to rounding.
  void accepted(const Landing<Scalar>& landed) {
    if (!landed.is_node) return;
    done_ += landed.steps;
    node_ = landed.end;
  }
  void archive(auto& ar) {
    ar("done", done_, "node", node_);
    ar.check(0 <= done_ && done_ <= steps_ && std::isfinite(node_));
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
  /// The length from node n to t, however coarse the clock is: t − t₀ − nΔt.
  [[nodiscard]] Scalar from_node(std::int64_t n, Scalar t) const {
    return n >= steps_ ? t - span_.t1 : std::fma(static_cast<Scalar>(-n), dt_, t - span_.t0);
  }

  FixedStep control_;
  TimeSpan<Scalar> span_{};
  Scalar dt_{0}, last_{0};
  std::int64_t steps_ = 0, done_ = 0;
  Scalar node_{0};  // [time] where the last node was reached
};

}}  // namespace phistep::PHISTEP_ABI
