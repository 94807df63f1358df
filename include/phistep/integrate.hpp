/// @file
/// The loop: stepper × controller × observers.
#pragma once

#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>

#include "phistep/control/fixed_step.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/stepper/transaction.hpp"

namespace phistep::inline PHISTEP_ABI {

/// How a run ended, and what it did. Contextually true where it reached t1.
struct [[nodiscard]] RunReport {
  Outcome outcome = Outcome::success;
  double t = 0;           ///< [time] where the state stands now
  Statistics statistics;  ///< of this run alone
  Failure failure;        ///< of the step that ended the run, if one did

  [[nodiscard]] explicit operator bool() const { return outcome == Outcome::success; }
  /// What happened, where, and what to try.
  [[nodiscard]] std::string message() const {
    return failure.outcome == outcome && outcome != Outcome::success ? failure.message() : explain(outcome);
  }

  template <class OStream>
    requires requires(OStream& out) { out << "" << 0.0 << std::int64_t{}; }
  friend OStream& operator<<(OStream& out, const RunReport& report) {
    out << report.message() << "\n  reached t           " << report.t << '\n' << report.statistics;
    return out;
  }
};

/// Shows (t, state) to one observer. False where it asks for the end.
template <class Observer, class Scalar, class S>
[[nodiscard]] bool show(Observer& observer, Scalar t, S& state) {
  static_assert(!std::is_const_v<Observer> || std::is_invocable_v<Observer&, Scalar, S&>,
                "phistep: this observer changes as it observes, so it can't be const");
  static_assert(std::is_const_v<Observer> || std::is_invocable_v<Observer&, Scalar, S&>,
                "phistep: an observer must be callable as observer(t, state), returning nothing or false to stop");
  if constexpr (!std::is_invocable_v<Observer&, Scalar, S&>) {
    return false;
  } else if constexpr (std::is_void_v<std::invoke_result_t<Observer&, Scalar, S&>>) {
    observer(t, state);
    return true;
  } else {
    return static_cast<bool>(observer(t, state));
  }
}

/// One step, passing on who vouches for the state to steppers that can use it.
template <class Stepper, class S, class Scalar>
StepReport advance(Stepper& stepper, S& state, Scalar t, Scalar dt, [[maybe_unused]] Origin origin) {
  if constexpr (requires { stepper.step(state, t, dt, origin); }) return stepper.step(state, t, dt, origin);
  else return stepper.step(state, t, dt);
}

/// Steps `state` from span.t0 to exactly span.t1 in steps of `step.dt` (a shorter last one where it doesn't divide).
/// @param observers  called at t0 and after every step as observer(t, state); one that returns false ends the run
/// @return outcome, time reached, counts; on failure the state is that of the last good step
template <class Stepper, State S, class... Observers>
RunReport integrate(Stepper& stepper, S& state, TimeSpan<std::type_identity_t<ScalarOf<S>>> span, const FixedStep& step,
                    Observers&&... observers) {
  using Scalar = ScalarOf<S>;
  // An observer may edit the state, if only through a capture: then the stepper must look.
  constexpr bool unedited = sizeof...(Observers) == 0;
  const Statistics before = stepper.statistics();
  RunReport report;
  const auto ended = [&](Outcome outcome, Scalar t) {
    report.outcome = outcome;
    report.t = static_cast<double>(t);
    report.statistics = stepper.statistics() - before;
    return report;
  };

  const TimeGrid<Scalar> grid(span, step);
  if (grid.outcome() != Outcome::success) return ended(grid.outcome(), span.t0);
  if (!(show(observers, span.t0, state) && ...)) return ended(Outcome::stopped_by_observer, span.t0);
  for (std::int64_t n = 0; n < grid.steps(); ++n) {
    const Scalar t = grid.time(n);
    // The first step can't know who had the state before.
    const Origin origin = unedited && n > 0 ? Origin::unedited : Origin::unknown;
    if (const StepReport done = advance(stepper, state, t, grid.step(n), origin); !done) {
      report.failure = done.failure();
      return ended(done.outcome(), t);
    }
    if (!(show(observers, grid.time(n + 1), state) && ...))
      return ended(Outcome::stopped_by_observer, grid.time(n + 1));
  }
  return ended(Outcome::success, grid.time(grid.steps()));
}

}  // namespace phistep::inline PHISTEP_ABI
