/// @file
/// How fast the fastest component of a solution could change: ρ = |λ|max of ∂y'/∂y, by a few force calls and no matrix; and how it
/// is followed during a run.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/run/choice/stiffness_watch.hpp"
#include "phistep/run/control/run_clock.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// |λ|max of ∂y'/∂y by the nonlinear power method (B. P. Sommeijer, L. F. Shampine & J. G. Verwer, J. Comput. Appl. Math. 88
/// (1998) 315), two products at a time, so that a pair ±iω counts like a real λ. An estimate from below. The direction found
/// is where the next estimate starts.
template <State Plain>
class SpectralRadius {
 public:
  using Scalar = ScalarOf<Plain>;
  explicit SpectralRadius(const Plain& y) : direction_{y}, slope_{y}, moved_{y}, first_{y} {
    Xorshift random{88172645463325252u};
    for_each_number([&random](auto, Scalar& x) { x = static_cast<Scalar>(random.number() - 0.5); },
                    Blocks<Plain>::all(direction_));
  }
  /// Starts from e, where that is more than nothing: the error of a step that stability limits lies along the fastest mode.
  void start_along(const Plain& e, const Plain& weight) {
    const double size = weighted_rms(e, weight);
    if (!(size > 0) || !std::isfinite(size)) return;
    copy_blocks<Plain>(direction_, e);
    scaled_ = true;
  }

  /// At (t, y): 1 + 2 pairs calls at most. @param f  f(t, y, out) → bool: out = y'. @param weight  1/(atol + rtol|y|), whose
  /// rtol is `rtol`. @param trifling  [1/time] an estimate below it is not refined. @return 0 where y' is not finite
  [[nodiscard]] double operator()(auto&& f, Scalar t, const Plain& y, const Plain& weight, double rtol, int pairs = 4,
                                  double trifling = 0) {
    turn_ = 1;
    if (!f(t, y, slope_)) return 0;
    // Directions are measured in weights; a probe moves y by √u of |y| + atol/rtol.
    const double u = static_cast<double>(std::numeric_limits<Scalar>::epsilon()), reach = std::sqrt(u) / rtol;
    double rho = 0;
    scale_by_weights(weight);
    double size = weighted_rms(direction_, weight);
    for (int k = 0; k < pairs; ++k) {
      double grown = 1;
      const double before = size;
      copy_blocks<Plain>(first_, direction_);
      for (int half = 0; half < 2; ++half) {
        if (!(size > 0) || !std::isfinite(size)) return rho;
        const auto by = static_cast<Scalar>(reach / size), back = static_cast<Scalar>(1 / reach);
        assign<Plain>(moved_, in<Plain>(y) + by * in<Plain>(direction_));
        if (!f(t, moved_, direction_)) return rho;
        // the product with a direction of size 1
        assign<Plain>(direction_, back * (in<Plain>(direction_) - in<Plain>(slope_)));
        size = weighted_rms(direction_, weight);
        grown *= size;
      }
      rho = std::sqrt(grown);
      if (size > 0) find_turn(before, size, weight);
      if (rho < trifling) break;
    }
    return rho;
  }
  /// cos 2θ of λ = ρ exp(iθ), about: 1 for a real λ, −1 for ±iω. Of the last estimate; 1 where that one ended early. No
  /// checkpoint has it: it is asked for after an estimate.
  [[nodiscard]] double turn() const { return turn_; }
  /// y' at the y of the last estimate.
  [[nodiscard]] const Plain& slope() const { return slope_; }

  void archive(auto& ar) { ar("scaled", scaled_), ar.in_place("direction", direction_, "slope", slope_); }

 private:
  /// J² d is λ² d: along d for a real λ, against it for ±iω. |u + w|² = 2 + 2 cos(u, w) of two of size 1.
  void find_turn(double before, double after, const Plain& weight) {
    const auto a = static_cast<Scalar>(1 / before), b = static_cast<Scalar>(1 / after);
    assign<Plain>(moved_, a * in<Plain>(first_) + b * in<Plain>(direction_));
    const double sum = weighted_rms(moved_, weight);
    turn_ = sum * sum / 2 - 1;
  }
  /// The first direction is random in every component's own scale.
  void scale_by_weights(const Plain& weight) {
    if (scaled_) return;
    scaled_ = true;
    for_each_number(
        [](auto, Scalar& d, Scalar w) {
          if (w > 0) d /= w;
        },
        Blocks<Plain>::all(direction_), Blocks<Plain>::all(weight));
  }

  Plain direction_, slope_, moved_, first_;
  double turn_ = 1;
  bool scaled_ = false;
};

/// Estimates the rate ρ = |λ|max of ∂y'/∂y where a run stands, for the rules of stiffness_watch.hpp: along which direction, in
/// which weights, and how much y' has changed since the last estimate.
template <State Plain>
class RateLook {
 public:
  using Scalar = ScalarOf<Plain>;
  /// @param y  gives the sizes
  explicit RateLook(const Plain& y) : radius_{y}, slope_before_{y} {}

  /// The estimate at (t, y), in the weights of the run: three calls, as a direction is known. The first direction is random; where
  /// it shows a change within a step, two calls more refine it. One fast mode among n unknowns seems slower by about n^¼: a start
  /// that is stiff enough for an implicit scheme still shows.
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
  /// What the last estimate found.
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
  /// @param passed  [time] since the estimate before; 0: no matter how long a step might be
  void compare(const Plain& now, const Plain& weight, double passed) {
    const double speed = weighted_rms(now, weight), noise = 10 * seen_.rate,
                 size = std::max({speed, weighted_rms(slope_before_, weight), noise});
    assign<Plain>(slope_before_, in<Plain>(slope_before_) - in<Plain>(now));
    const double change = weighted_rms(slope_before_, weight);
    if (!(size > 0)) return;
    seen_.change = change / size;
    // (1) of variable_step.hpp with p = 5 and τ from two slopes; the errors of implicit schemes have small factors.
    if (change > noise && passed > 0) {
      const double tau = passed / seen_.change;
      seen_.smooth_step = 3 * tau / std::pow(speed * tau, 1.0 / 6);
    }
  }

  SpectralRadius<Plain> radius_;
  Plain slope_before_;  ///< y' at the last estimate
  RateSeen seen_;
  bool has_looked_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
