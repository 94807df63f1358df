/// @file
/// What a stepper that chooses its scheme knows of its way so far.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/norms.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/choice/scheme_uses.hpp"
#include "phistep/run/choice/spectral_radius.hpp"
#include "phistep/run/choice/stiffness_watch.hpp"
#include "phistep/run/control/run_clock.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Estimates the rate ρ = |λ|max of ∂y'/∂y where a run stands, for the rules of stiffness_watch.hpp: along which direction, in
/// which weights, and how much y' has changed since the last estimate.
template <State Plain>
class RateLook {
 public:
  using Scalar = ScalarOf<Plain>;
  /// @param y  gives the sizes
  explicit RateLook(const Plain& y) : radius_{y}, slope_before_{y} {}

  /// At (t, y), in the weights of the run. Three calls: a direction is at hand. The first direction is random; where it shows a
  /// change within a step, two calls more refine it. One fast mode among n unknowns looks slower by n^¼ or so: a start that is
  /// stiff enough for an implicit scheme shows.
  /// @param slope        slope(t, y, out) → bool: out = y'
  /// @param is_explicit  the scheme at work: then the error of its last step lies along the fastest mode, if stability limits it
  const RateSeen& operator()(auto&& slope, const Plain& y, const RunClock<Scalar>& clock, auto& pace,
                             bool is_explicit) {
    if (!same_shape<Plain>(slope_before_, y)) *this = RateLook{y};
    auto& trace = pace.trace();
    const double rtol = pace.weigh(y, trace.weight);
    if (has_looked_ && is_explicit) radius_.start_along(trace.error, trace.weight);
    const double left = std::abs(static_cast<double>(clock.length_to(clock.span().t1))), passed = seen_.left - left;
    const double dt = pace.propose();
    seen_ = {
        .rate = radius_(slope, clock.t(), y, trace.weight, rtol, has_looked_ ? 1 : 2, 1 / dt), .dt = dt, .left = left};
    seen_.turn = radius_.turn();
    if (has_looked_) compare(radius_.slope(), trace.weight, is_explicit ? passed : 0);
    copy_blocks<Plain>(slope_before_, radius_.slope());
    has_looked_ = true;
    return seen_;
  }
  [[nodiscard]] bool has_looked() const { return has_looked_; }
  /// What the last look found.
  [[nodiscard]] const RateSeen& seen() const { return seen_; }
  /// A state of the right sizes.
  [[nodiscard]] const Plain& sample() const { return slope_before_; }

  void archive(auto& ar) {
    ar("radius", radius_, "seen", seen_, "has_looked", has_looked_);
    ar.in_place("slope_before", slope_before_);
  }

 private:
  /// What y' has become, and what that says; y'₀ is lost. What moves y by less than ten tolerances within 1/ρ is noise of the
  /// fastest modes, and no change.
  /// @param passed  [time] since the look before; 0: no matter how long a step might be
  void compare(const Plain& now, const Plain& weight, double passed) {
    const double speed = weighted_rms(now, weight), noise = 10 * seen_.rate,
                 size = std::max({speed, weighted_rms(slope_before_, weight), noise});
    assign<Plain>(slope_before_, in<Plain>(slope_before_) - in<Plain>(now));
    const double change = weighted_rms(slope_before_, weight);
    if (!(size > 0)) return;
    seen_.change = change / size;
    // (1) of first_step.hpp with p = 5 and τ from two slopes; the errors of implicit schemes have small factors.
    if (change > noise && passed > 0) {
      const double tau = passed / seen_.change;
      seen_.smooth_step = 3 * tau / std::pow(speed * tau, 1.0 / 6);
    }
  }

  SpectralRadius<Plain> radius_;
  Plain slope_before_;  ///< y' at the last look
  RateSeen seen_;
  bool has_looked_ = false;
};

/// What its checkpoint holds beside the scheme at work.
template <State Plain>
struct AutomaticCourse {
  StiffnessWatch watch;
  RateLook<Plain> look;
  bool is_bound;           ///< to the scheme at work, although or because it is stiff
  bool is_direct = false;  ///< Krylov iterations have failed: no more of them
  SchemeUses uses{};
  Statistics retired{};              ///< of the schemes before
  std::int64_t changes = 0;          ///< of the forces of these
  std::int64_t steps = 0, done = 0;  ///< steps seen, steps since
  void archive(auto& ar) {
    ar("watch", watch, "look", look, "uses", uses, "retired", retired, "steps", steps, "done", done, "changes", changes,
       "is_bound", is_bound, "is_direct", is_direct);
    ar.check(can_be_count(steps) && can_be_count(done));
  }
};

}}  // namespace phistep::PHISTEP_ABI
