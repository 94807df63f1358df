/// @file
/// The state inside a step that has been done, by a shorter step from the same start: by a copy of the stepper, so that the
/// run goes on without a change. Under a tolerance its error is tested as that of any step, and where it fails it
/// is done as two halves.
#pragma once

#include <optional>

#include "phistep/control/trace.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/version.hpp"
#include "phistep/problem/edit_guard.hpp"
#include "phistep/problem/transaction.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/step/past.hpp"
#include "phistep/step/step_doubling.hpp"

namespace phistep::inline PHISTEP_ABI {

template <class Stepper, State S>
class StepInside {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  /// @param stepper  as the step left it
  /// @param past     its checkpoint before that step
  explicit StepInside(const Stepper& stepper, const Past<Stepper>& past)
      : stepper_{stepper}, past_{past}, before_{stepper_.statistics()} {}
  /// state = y(t + dt) from y(t), by one step at a fixed Δt, or by as many as the error asks for.
  /// @param pace  the run's, whose tolerances hold
  template <class Pace>
  [[nodiscard]] StepReport step(S& state, Scalar t, Scalar dt, Pace& pace) {
    go_back(stepper_, past_);
    if constexpr (Pace::sees_error) {
      trace_ = pace.trace();
      trace_.wants_dense = false;
      return part(state, t, dt, pace, 0);
    } else {
      return stepper_.step(state, t, dt);
    }
  }
  /// What it has cost so far.
  [[nodiscard]] Statistics spent() const { return stepper_.statistics() - before_; }

 private:
  StepReport part(S& state, Scalar t, Scalar dt, auto& pace, int halvings) {
    trace_.forget();
    const StepReport done = attempt(state, t, dt, pace);
    const bool may_halve = done.outcome() == Outcome::error_too_large || may_be_cured(done.outcome());
    if (done || halvings == 20 || !may_halve) return done;
    const Scalar half = dt / 2;
    const StepReport first = part(state, t, half, pace, halvings + 1);
    return first ? part(state, t + half, half, pace, halvings + 1) : first;
  }
  StepReport attempt(S& state, Scalar t, Scalar dt, auto& pace) {
    const auto allows = [&](const Plain& y, const Plain& next, const auto& told) { return pace.allows(y, next, told); };
    if constexpr (can_trace<Stepper>)
      if (stepper_.estimates(trace_)) return stepper_.attempt(state, t, dt, Origin::unknown, trace_, allows);
    doubling_.emplace();
    Plain like;
    copy_blocks<S>(like, state);
    doubling_->resize(like);
    return doubling_->attempt(stepper_, state, t, dt, Origin::unknown, trace_, allows);
  }

  Stepper stepper_;
  [[no_unique_address]] Past<Stepper> past_;
  Statistics before_;
  Trace<Plain> trace_;
  std::optional<StepDoubling<Stepper, S>> doubling_;
};

}  // namespace phistep::inline PHISTEP_ABI
