/// @file
/// When to change between an explicit and an implicit scheme: tests by the rate ρ = |λ|max of ∂y'/∂y and by counts, never by
/// a clock.
///
/// Explicit: Δt is limited by stability where ρΔt stays at the scheme's bound β (Hairer & Wanner, Solving ODEs II, sect. IV.2,
/// p. 21), above all if y' hardly changes in such a step; at tight tolerances its error is large before that, where a fast mode
/// follows a slow solution. Where the rest of the run would then cost more than the implicit
/// steps that its error allows, an implicit scheme takes over.
/// Implicit: over Δt an explicit scheme would need ρΔt/0.7β steps, at least one. Where these cost less, it takes over.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What an estimate of the rate has found.
struct RateSeen {
  double rate = 0;    ///< [1/time] ρ, from below; 0: not known
  double dt = 0;      ///< [time] the step just done, or about to be done where there was none
  double left = 0;    ///< [time] to the end of the run
  double change = 1;  ///< of y' since the estimate before, relative; 1: not known
  double turn = 1;    ///< cos 2θ of λ = ρ exp(iθ): −1 for ±iω
  double smooth_step =
      std::numeric_limits<double>::infinity();  ///< [time] that the error would allow but for stability
  void archive(auto& ar) {
    ar("rate", rate, "dt", dt, "left", left, "change", change, "turn", turn, "smooth_step", smooth_step);
  }
};

/// The fastest mode is no decay: |arg λ| within 30 degrees of 90.
[[nodiscard]] inline bool oscillates(const RateSeen& seen) { return seen.turn < -0.5; }

/// Two schemes as numbers.
struct RivalSteps {
  double bound = 3;          ///< β of the explicit one
  double explicit_cost = 1;  ///< of a step
  double implicit_cost = 1;  ///< of a step, in the same unit
};

class StiffnessWatch {
 public:
  explicit StiffnessWatch(const RivalSteps& rivals = {}) : rivals_{rivals} {}

  [[nodiscard]] bool is_implicit() const { return implicit_; }
  /// What an implicit step costs, once its matrix is known.
  void set_implicit_cost(double cost) { rivals_.implicit_cost = cost; }

  /// A step has been done. @param next  [time] of the one to come
  void accepted(double next) {
    ++spell_, ++since_;
    if (next > 1.5 * reference_) reference_ = next, steady_ = 0;
    else reference_ = std::max(reference_ / 1.5, next), ++steady_;
  }
  void rejected() { rejected_ = true; }

  /// Whether the rate should be estimated.
  [[nodiscard]] bool is_due() const {
    if (implicit_) return spell_ >= 8 && since_ >= period_;
    return steady_ >= 5 && since_ >= (rejected_ ? std::max(2, period_ / 3) : period_);
  }
  /// Whether what explicit steps would be left is worth more than the implicit ones, and 8 for the change.
  [[nodiscard]] bool pays(const RateSeen& seen) const { return pays(seen, rivals_.implicit_cost); }
  /// The same where an implicit step costs that.
  [[nodiscard]] bool pays(const RateSeen& seen, double cost) const {
    return explicit_cost_of(seen) > implicit_steps(seen) * cost;
  }
  /// Whether stability limits the explicit step, about.
  [[nodiscard]] bool is_at_limit(const RateSeen& seen) const {
    return !implicit_ && seen.rate * seen.dt > 0.5 * rivals_.bound;
  }
  /// At the start of a run: whether it should begin with an implicit scheme.
  /// @param is_small  some explicit steps are much of a run
  [[nodiscard]] bool starts_stiff(const RateSeen& seen, bool is_small) const {
    return (seen.rate * seen.dt > 5 * rivals_.bound && pays(seen)) || (is_small && is_hopeless(seen));
  }
  /// Whether the scheme should change.
  [[nodiscard]] bool judge(const RateSeen& seen) {
    since_ = 0;
    rejected_ = false;
    return implicit_ ? is_eased(seen) : is_stiff(seen);
  }
  void change() {
    // A spell that was short was not worth it: the next time more is asked for.
    int& needs = implicit_ ? needs_stiff_ : needs_eased_;
    needs = spell_ < 40 ? std::min(2 * needs, 8) : spell_ > 400 ? 1 : needs;
    implicit_ = !implicit_;
    start_spell();
  }
  void begin_implicit() {
    implicit_ = true;
    start_spell();
  }
  /// [time] of the first explicit step.
  [[nodiscard]] double stable_step(const RateSeen& seen) const { return 0.7 * rivals_.bound / seen.rate; }

  void archive(auto& ar) {
    ar("implicit", implicit_, "rejected", rejected_, "spell", spell_, "since", since_, "steady", steady_, "period",
       period_, "hits", hits_, "needs_stiff", needs_stiff_, "needs_eased", needs_eased_, "reference", reference_,
       "implicit_cost", rivals_.implicit_cost);
    ar.check(spell_ >= 0 && since_ >= 0 && steady_ >= 0 && period_ >= 0 && hits_ >= 0 && needs_stiff_ >= 1 &&
             needs_eased_ >= 1 && std::isfinite(reference_));
  }

 private:
  /// The cost of the rest of the run by explicit steps at their limit.
  [[nodiscard]] double explicit_cost_of(const RateSeen& seen) const {
    return seen.left * seen.rate / rivals_.bound * rivals_.explicit_cost;
  }
  /// As many as the rest of the run takes, and 8 for the change.
  [[nodiscard]] static double implicit_steps(const RateSeen& seen) { return 8 + seen.left / seen.smooth_step; }
  /// Explicit steps at their limit would cost more than 40 implicit ones, as many as most runs take: a decay will be stiff as soon as it has
  /// passed. Where it is not, some 20 steps lead back.
  [[nodiscard]] bool is_hopeless(const RateSeen& seen) const {
    return seen.turn > 0.5 && explicit_cost_of(seen) > 40 * rivals_.implicit_cost;
  }
  /// The error of explicit steps is that of a fast mode behind a slow solution, which would allow much longer ones.
  [[nodiscard]] bool is_held(const RateSeen& seen) const {
    return seen.rate * seen.dt > 1.5 && seen.smooth_step > 8 * seen.dt && !oscillates(seen) &&
           seen.left / seen.dt * rivals_.explicit_cost > 1.5 * implicit_steps(seen) * rivals_.implicit_cost;
  }
  [[nodiscard]] bool is_stiff(const RateSeen& seen) {
    const double share = seen.rate * seen.dt / rivals_.bound;
    const bool it_pays = pays(seen);
    if (it_pays && share > 0.5 && seen.change < 0.5) hits_ += 2;
    else if (it_pays && seen.rate * seen.dt > 0.75 * rivals_.bound)
      hits_ += 1;  // no resolved oscillation has such steps
    else if (is_held(seen)) hits_ += 1;
    else hits_ = it_pays ? std::max(0, hits_ - 1) : 0;  // Δt swings about its bound
    period_ = hits_ > 0 ? 2 : share > 0.2 ? 25 : 50;
    return hits_ >= 3 * needs_stiff_;
  }
  [[nodiscard]] bool is_eased(const RateSeen& seen) {
    const double steps = std::max(1.0, seen.rate * seen.dt / (0.7 * rivals_.bound)),
                 gain = rivals_.implicit_cost / (steps * rivals_.explicit_cost);
    // Oscillations that an explicit scheme hardly damps stay once they are there: only such as are resolved are left to it.
    if (seen.rate > 0 && gain > 2 && (steps == 1 || !oscillates(seen))) ++hits_;
    else hits_ = 0;
    period_ = hits_ > 0 ? 3 : gain > 0.05 ? 10 : 40;
    return hits_ >= 4 * needs_eased_;
  }
  void start_spell() {
    rejected_ = false;
    spell_ = since_ = steady_ = 0;
    hits_ = period_ = 0;
    reference_ = 0;
  }

  RivalSteps rivals_;
  bool implicit_ = false, rejected_ = false;
  std::int64_t spell_ = 0, since_ = 0, steady_ = 0;
  int period_ = 0;  ///< steps between two estimates
  int hits_ = 0, needs_stiff_ = 1, needs_eased_ = 1;
  double reference_ = 0;  ///< [time] the longest step of late
};

}}  // namespace phistep::PHISTEP_ABI
