/// @file
/// States inside a step that has been done, by the interpolants of shorter steps: where the step's own interpolant is off,
/// that of a part of it, m times shorter, is off by m⁴ times less or better. For many states inside one step this costs m
/// steps, in place of one for each state (step_inside.hpp).
#pragma once

#include <cmath>
#include <utility>

#include "phistep/control/trace.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/version.hpp"
#include "phistep/observe/dense_output.hpp"
#include "phistep/problem/transaction.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/step/step_doubling.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Walks through the step part by part, in a copy of its stepper.
template <class Stepper, State S>
class PartsInside {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  /// The step from `start` at t0 to t0 + dt, in so many parts.
  /// @param stepper  as the step left it
  /// @param past     its checkpoint before that step
  /// @param trace    the run's, whose tolerances hold
  PartsInside(const Stepper& stepper, const auto& past, const Plain& start, Scalar t0, Scalar dt, int parts,
              const Trace<Plain>& trace)
      : stepper_{stepper},
        before_{stepper_.statistics()},
        trace_{trace},
        t0_{t0},
        length_{dt / static_cast<Scalar>(parts)},
        parts_{parts} {
    if constexpr (requires { stepper_.restore(past); }) stepper_.restore(past);
    else if constexpr (requires { stepper_.reset(); }) stepper_.reset();
    trace_.forget();
    trace_.wants_dense = true;
    y_ = next_ = slope0_ = slope1_ = start;
  }
  PartsInside(const PartsInside&) = delete;
  PartsInside& operator=(const PartsInside&) = delete;

  /// Whether t lies in a part that this one has already gone past.
  [[nodiscard]] bool is_past(Scalar t) const { return (t - t0_) / length_ < static_cast<Scalar>(done_ - 1); }
  /// out = y(t). False where a part fails, its error is too large or unknown.
  /// @param state  scratch
  template <class Accept>
  [[nodiscard]] bool at(S& state, Scalar t, Plain& out, Accept&& accept) {
    if (has_given_up_) return false;
    while (done_ == 0 || (done_ < parts_ && (t - t0_) / length_ > static_cast<Scalar>(done_)))
      if (!step(state, accept)) return false;
    copy_blocks<S>(out, dense_.at(t));
    return true;
  }
  /// What it has cost so far.
  [[nodiscard]] Statistics spent() const { return stepper_.statistics() - before_; }

 private:
  static constexpr bool interpolates = requires { requires Stepper::interpolates; };

  /// The next part. Where it fails, all is as before, or given up for good.
  bool step(S& state, auto& accept) {
    if constexpr (can_trace<Stepper>) {
      if (done_ > 0) {
        trace_.advance();
        copy_blocks<S>(y_, next_);
      }
      if (!stepper_.estimates(trace_)) return false;
      const Scalar t = t0_ + static_cast<Scalar>(done_) * length_;
      copy_blocks<S>(state, y_);
      const auto judge = [&](const Plain& y, const Plain& next, const auto& traced) {
        return traced.proposed != 0 || accept(y, next, traced.error);  // a scheme that proposes Δt has judged
      };
      if (!stepper_.attempt(state, t, length_, Origin::unknown, trace_, judge)) return false;
      if (!interpolates && !trace_.has_slopes) return !(has_given_up_ = true);
      copy_blocks<S>(next_, state);
      ++done_;
      if (trace_.has_slopes) {
        copy_blocks<S>(slope0_, trace_.start);
        copy_blocks<S>(slope1_, trace_.end);
      }
      dense_.begin(t, length_, y_, next_, {this, [](void* self, Plain& at_start, Plain& at_end) {
                                             copy_blocks<S>(at_start, static_cast<PartsInside*>(self)->slope0_);
                                             copy_blocks<S>(at_end, static_cast<PartsInside*>(self)->slope1_);
                                           }});
      if constexpr (interpolates)
        dense_.interpolate_by(
            &stepper_, [](const void* stepper, Scalar x, Scalar h, const Plain& y0, const Plain& y1, Plain& out) {
              static_cast<const Stepper*>(stepper)->interpolate(x, h, y0, y1, out);
            });
      return true;
    } else {
      return false;
    }
  }

  Stepper stepper_;
  Statistics before_;
  Trace<Plain> trace_;
  Scalar t0_, length_;
  int parts_, done_ = 0;
  bool has_given_up_ = false;
  Plain y_, next_, slope0_, slope1_;  // of the part that was done last
  DenseOutput<S> dense_;
};

}  // namespace phistep::inline PHISTEP_ABI
