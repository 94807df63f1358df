/// @file
/// States inside a step that has been done, by the interpolants of shorter steps: where the step's own interpolant is off,
/// that of a part of it, m times shorter, is off by m⁴ times less or better. For many states inside one step this costs m
/// steps, in place of one for each state (step_inside.hpp).
#pragma once

#include "phistep/base/facts/stepper_facts.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/inside/dense_output.hpp"
#include "phistep/run/stepper/any_stepper.hpp"
#include "phistep/run/stepper/spare_stepper.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Walks through the step part by part, in a copy of its stepper.
template <class Stepper, State S>
class PartsInside {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  PartsInside() = default;
  PartsInside(const PartsInside&) = delete;
  PartsInside& operator=(const PartsInside&) = delete;

  /// The step from `start` at t0 to t0 + dt has been done, and is to be done again in so many parts.
  /// @param stepper  as the step left it
  /// @param past     its checkpoint before that step
  /// @param trace    the run's, whose tolerances hold
  void begin(const Stepper& stepper, const Past<Stepper>& past, const Plain& start, Scalar t0, Scalar dt, int parts,
             const Trace<Plain>& trace) {
    end();
    spare_.copy(stepper);
    go_back(*spare_, past);
    trace_ = trace;
    trace_.forget();
    trace_.wants_dense = true;
    y_ = next_ = slope0_ = slope1_ = start;
    t0_ = t0;
    length_ = dt / static_cast<Scalar>(parts);
    done_ = 0;
    has_given_up_ = false;
    parts_ = parts;
  }
  /// Until then there is none to look into.
  [[nodiscard]] bool has_begun() const { return parts_ > 0; }
  void end() { parts_ = 0; }

  /// Whether t lies in a part that this one has already gone past.
  [[nodiscard]] bool is_past(Scalar t) const { return (t - t0_) / length_ < static_cast<Scalar>(done_ - 1); }
  /// y(t), valid until the next call. Null where a part fails, its error is too large or unknown.
  /// @param state  scratch
  [[nodiscard]] const Plain* at(S& state, Scalar t, auto& pace) {
    if (has_given_up_) return nullptr;
    while (done_ == 0 || (done_ < parts_ && (t - t0_) / length_ > static_cast<Scalar>(done_)))
      if (!step(state, pace)) return nullptr;
    return &dense_.at(t);
  }
  /// What looks into this step have cost so far.
  [[nodiscard]] Statistics spent() const { return spare_.spent(); }

  /// y' at both ends of the part that was done last.
  void operator()(Plain& at_start, Plain& at_end) const {
    copy_blocks<S>(at_start, slope0_);
    copy_blocks<S>(at_end, slope1_);
  }

 private:
  static constexpr bool interpolates = facts_of<Stepper>.interpolates;

  /// The next part. Where it fails, all is as before, or given up for good.
  bool step(S& state, auto& pace) {
    if constexpr (facts_of<Stepper>.traces) {
      if (done_ > 0) {
        trace_.advance();
        copy_blocks<S>(y_, next_);
      }
      if (!spare_->estimates(trace_)) return false;
      const Scalar t = t0_ + static_cast<Scalar>(done_) * length_;
      copy_blocks<S>(state, y_);
      const auto allows = [&](const Plain& y, const Plain& next, const auto& told) {
        return pace.allows(y, next, told);
      };
      if (!spare_->attempt(state, t, length_, Origin::unknown, trace_, allows)) return false;
      if (!interpolates && !trace_.has_slopes) return !(has_given_up_ = true);
      copy_blocks<S>(next_, state);
      ++done_;
      if (trace_.has_slopes) {
        copy_blocks<S>(slope0_, trace_.start);
        copy_blocks<S>(slope1_, trace_.end);
      }
      dense_.begin(t, length_, y_, next_, DenseOutput<S>::Slopes::of(*this));
      dense_.interpolate_by(*spare_);
      return true;
    } else {
      return false;
    }
  }

  SpareStepper<Stepper> spare_;
  Trace<Plain> trace_;
  Scalar t0_{}, length_{};
  int parts_ = 0, done_ = 0;
  bool has_given_up_ = false;
  Plain y_, next_, slope0_, slope1_;  // of the part that was done last
  DenseOutput<S> dense_;
};

}}  // namespace phistep::PHISTEP_ABI
