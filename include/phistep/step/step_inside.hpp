/// @file
/// The state inside a step that has been done, by a shorter step from the same start: by a copy of the stepper, so that the
/// run goes on without a change. Under a tolerance its error is tested as that of any step, and where it fails it
/// is done as two halves.
#pragma once

#include <optional>
#include <type_traits>
#include <utility>

#include "phistep/control/trace.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/version.hpp"
#include "phistep/problem/edit_guard.hpp"
#include "phistep/problem/transaction.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/step/step_doubling.hpp"

namespace phistep::inline PHISTEP_ABI {

template <class Stepper, State S>
class StepInside {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  static constexpr bool is_possible = std::is_copy_constructible_v<Stepper>;
  static constexpr bool can_go_back = requires(Stepper & stepper) { stepper.restore(stepper.checkpoint()); };
  struct NoPast {};
  using Past = typename decltype([] {
    if constexpr (can_go_back) return std::type_identity<decltype(std::declval<Stepper&>().checkpoint())>{};
    else return std::type_identity<NoPast>{};
  }())::type;

  /// @param stepper  as the step left it
  /// @param past     its checkpoint before that step
  explicit StepInside(const Stepper& stepper, const Past& past)
      : stepper_{stepper}, past_{past}, before_{stepper_.statistics()} {}
  /// state = y(t + dt) from y(t), by one step at a fixed Δt.
  [[nodiscard]] StepReport step(S& state, Scalar t, Scalar dt) {
    restart();
    return stepper_.step(state, t, dt);
  }
  /// … by as many as the error asks for.
  /// @param watched  the run's, whose tolerances hold
  template <class Accept>
  [[nodiscard]] StepReport step(S& state, Scalar t, Scalar dt, const Trace<Plain>& watched, Accept&& accept) {
    restart();
    trace_ = watched;
    trace_.wants_dense = false;
    return part(state, t, dt, accept, 0);
  }
  /// What it has cost so far.
  [[nodiscard]] Statistics spent() const { return stepper_.statistics() - before_; }

 private:
  StepReport part(S& state, Scalar t, Scalar dt, auto& accept, int halvings) {
    trace_.forget();
    const StepReport done = attempt(state, t, dt, accept);
    const bool may_halve = done.outcome() == Outcome::error_too_large || may_be_cured(done.outcome());
    if (done || halvings == 20 || !may_halve) return done;
    const Scalar half = dt / 2;
    const StepReport first = part(state, t, half, accept, halvings + 1);
    return first ? part(state, t + half, half, accept, halvings + 1) : first;
  }
  StepReport attempt(S& state, Scalar t, Scalar dt, auto& accept) {
    const auto judge = [&](const Plain& y, const Plain& next, const auto& told) {
      return told.proposed != 0 || accept(y, next, told.error);  // who chooses Δt has judged
    };
    if constexpr (can_trace<Stepper>)
      if (stepper_.estimates(trace_)) return stepper_.attempt(state, t, dt, Origin::unknown, trace_, judge);
    doubling_.emplace();
    Plain like;
    copy_blocks<S>(like, state);
    doubling_->resize(like);
    return doubling_->attempt(stepper_, state, t, dt, Origin::unknown, trace_, judge);
  }

  /// The history is that of the step's start.
  void restart() {
    if constexpr (can_go_back) stepper_.restore(past_);
    else if constexpr (requires { stepper_.reset(); }) stepper_.reset();
  }

  Stepper stepper_;
  [[no_unique_address]] Past past_;
  Statistics before_;
  Trace<Plain> trace_;
  std::optional<StepDoubling<Stepper, S>> doubling_;
};

}  // namespace phistep::inline PHISTEP_ABI
