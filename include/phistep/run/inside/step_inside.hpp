/// @file
/// The state inside a step that has been done, by a shorter step from the same start: by a copy of the stepper, so that the
/// run goes on without a change. Under a tolerance its error is tested as that of any step, and where it fails it
/// is done as two halves.
#pragma once

#include <optional>
#include <type_traits>

#include "phistep/base/facts/stepper_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/stepper/any_stepper.hpp"
#include "phistep/run/stepper/step_doubling.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A copy of a run's stepper, to step beside the run. It is made once, and from then on assigned to: that allocates nothing
/// where sizes stay (and the force can be assigned, base/machine/assignable.hpp).
template <class Stepper>
class SpareStepper {
 public:
  void copy(const Stepper& stepper) {
    if constexpr (std::is_copy_assignable_v<Stepper>) stepper_ = stepper;
    else stepper_.emplace(stepper);
    before_ = stepper_->statistics();
  }
  [[nodiscard]] Stepper* operator->() { return &*stepper_; }
  [[nodiscard]] Stepper& operator*() { return *stepper_; }
  /// What it has cost since it is a copy.
  [[nodiscard]] Statistics spent() const { return stepper_->statistics() - before_; }

 private:
  std::optional<Stepper> stepper_;
  Statistics before_;
};

template <class Stepper, State S>
class StepInside {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  /// The step has been done.
  /// @param stepper  as the step left it
  /// @param past     its checkpoint before that step, to which this refers
  void begin(const Stepper& stepper, const Past<Stepper>& past) {
    spare_.copy(stepper);
    past_ = &past;
  }
  /// Until then there is none to look into.
  [[nodiscard]] bool has_begun() const { return past_ != nullptr; }
  void end() { past_ = nullptr; }
  /// state = y(t + dt) from y(t), by one step at a fixed Δt, or by as many as the error asks for.
  /// @param pace  the run's, whose tolerances hold
  template <class Pace>
  [[nodiscard]] StepReport step(S& state, Scalar t, Scalar dt, Pace& pace) {
    go_back(*spare_, *past_);
    if constexpr (Pace::sees_error) {
      trace_ = pace.trace();
      trace_.wants_dense = false;
      return part(state, t, dt, pace, 0);
    } else {
      return spare_->step(state, t, dt);
    }
  }
  /// What looks into this step have cost so far.
  [[nodiscard]] Statistics spent() const { return spare_.spent(); }

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
    if constexpr (facts_of<Stepper>.traces)
      if (spare_->estimates(trace_)) return spare_->attempt(state, t, dt, Origin::unknown, trace_, allows);
    return doubling_.attempt(*spare_, state, t, dt, Origin::unknown, trace_, allows);
  }

  SpareStepper<Stepper> spare_;
  const Past<Stepper>* past_ = nullptr;
  Trace<Plain> trace_;
  StepDoubling<Stepper, S> doubling_;
};

}}  // namespace phistep::PHISTEP_ABI
