/// @file
/// Ends a step at its first event. It is done again, shorter, and is then a step like any other, of the same scheme and with
/// the same error test, which may refuse it.
#pragma once

#include <cmath>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/control/run_clock.hpp"
#include "phistep/run/observers/completed_step.hpp"
#include "phistep/step/equation/origin.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @tparam Attempt  a StepAttempt
/// @tparam Look     a LookInside
/// @tparam Events   an EventSet
template <class Attempt, class Look, class Events>
class EventCut {
 public:
  using Scalar = typename Attempt::Scalar;
  using Found = typename Events::Found;

  EventCut(Attempt& step, Look& look, Events& events) : step_{step}, look_{look}, events_{events} {}

  /// The step that led to `to` has been done. If an event is found, `to` is where that is.
  /// @param found  the first event; the run ends if its outcome is not success
  /// @return the step's; unless it is a success, or where the run ends, or g or the force throws, all is as at its start
  [[nodiscard]] StepReport operator()(Landing<Scalar>& to, Found& found) {
    try {
      look_.begin(to.dt);
      const CompletedStep<typename Attempt::StateType> step{step_.t0(),    to.dt,         step_.clock().t(),
                                                            step_.start(), step_.plain(), look_};
      found = events_.find(step);
      // Where the interpolant is far off, it may have roots of its own: then the search is done by real steps.
      if ((found || failed(found.outcome)) && found.root.t != step.t1() && look_.was_off()) found = events_.find(step);
      StepReport done{Outcome::success, 0, nullptr};
      if (found) done = go_to(found, to);
      if (!done) return done;
      if (found) events_.look(found, step_.clock().t(), step_.state());
      // Where g passes zero inside the step, slopes that are none say so.
      if (!failed(found.outcome)) found.outcome = look_.outcome();
      if (failed(found.outcome)) step_.undo();
      return done;
    } catch (...) {
      step_.undo_for_good();
      throw;
    }
  }

 private:
  /// Does the step again, up to the event.
  [[nodiscard]] StepReport go_to(Found& found, Landing<Scalar>& to) {
    StepReport done{Outcome::success, 0, nullptr};
    Landing<Scalar> shorter = to;
    const auto hit = events_.refine(found, [&](Scalar t) -> const typename Attempt::Plain* {
      step_.undo();
      shorter = to;
      if (t != to.end || !to.lands) shorter = {.end = t, .dt = step_.length_to(t), .lands = true, .clipped = true};
      shorter.at_stop = true;
      done = step_.attempt(shorter, Origin::unknown, false);
      return done ? &step_.plain() : nullptr;
    });
    if (done && hit.resteps > 0) look_.begin_again(shorter.dt);
    if (done && !std::isfinite(hit.g)) found.outcome = Outcome::non_finite_event;
    if (hit.resteps > 0) to = shorter;
    to.at_stop = true;
    if (!done) step_.undo();
    return done;
  }

  Attempt& step_;
  Look& look_;
  Events& events_;
};

}}  // namespace phistep::PHISTEP_ABI
