/// @file
/// A run, step by step: stepper × pace × observers. `integrate` is one that goes on to its end.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/archive/archive.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/run/control/fixed_step.hpp"
#include "phistep/run/control/iteration_control.hpp"
#include "phistep/run/control/pace.hpp"
#include "phistep/run/control/run_clock.hpp"
#include "phistep/run/control/run_report.hpp"
#include "phistep/run/errors/tolerance.hpp"
#include "phistep/run/inside/look_inside.hpp"
#include "phistep/run/observers/completed_step.hpp"
#include "phistep/run/observers/event_set.hpp"
#include "phistep/run/observers/observers.hpp"
#include "phistep/run/stepper/any_stepper.hpp"
#include "phistep/run/stepper/step_attempt.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/transaction/edit_guard.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The pace that a control asks for.
template <State S>
[[nodiscard]] GridPace<ScalarOf<S>> pace_of(const FixedStep& control) {
  return GridPace<ScalarOf<S>>{control};
}
template <State S, class Control>
  requires(std::is_same_v<Control, tolerance> || std::is_same_v<Control, SmallerOf>)
[[nodiscard]] ErrorPace<PlainState<S>> pace_of(const Control& control) { return ErrorPace<PlainState<S>>{control}; }
template <State S>
[[nodiscard]] IterationPace<PlainState<S>> pace_of(const iteration_control& control) {
  return IterationPace<PlainState<S>>{control};
}

/// What a run takes as its control.
template <class Control, class S>
concept ControlOf = requires(const Control& control) {
  pace_of<S>(control);
};

/// The stepper may have been made for a state of this type.
template <class Stepper, class S>
concept FitsState = !requires {
  typename Stepper::StateType;
}
|| std::is_same_v<typename Stepper::StateType, S>;

/// The times of a run; of no state, to be refused later.
template <class S>
struct SpanOf : std::type_identity<TimeSpan<double>> {};
template <State S>
struct SpanOf<S> : std::type_identity<TimeSpan<ScalarOf<S>>> {};

template <class Stepper, class S, class Control>
concept CanRun = MutableState<S&> && ControlOf<Control, S> && FitsState<Stepper, S>;

/// A run from span.t0 to exactly span.t1 that stops between steps whenever the caller likes:
///
///     Run run{stepper, state, {0.0, 10.0}, tolerance{.rtol = 1e-6}, observers…};
///     while (run.advance()) …                                  // one accepted step each; edit the state if you must
///     std::cout << run.report();
///
/// It refers to the stepper, the state and those observers that are given as lvalues: they must outlive it.
template <class Stepper, class S, class Control, class... Observers>
class Run {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using ArchivedByParts = void;
  static constexpr const char* part_name = "run";

  Run(Stepper& stepper, S& state, TimeSpan<std::type_identity_t<Scalar>> span, const Control& control,
      Observers&&... observers)
      : stepper_{stepper},
        state_{state},
        step_{stepper, state, span, pace_of<S>(control)},
        observers_{std::forward<Observers>(observers)...},
        events_{observers_.events()},
        before_{stepper.statistics()} {}
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  /// One step, and what observers make of it. False once the run has ended, with report() telling how.
  bool advance() { return step(true); }
  /// All the way.
  RunReport finish() {
    // From here on only observers can edit the state between steps.
    alone_ = sizeof...(Observers) == 0;
    for (bool edited = true; step(edited) && go_on();) edited = !alone_;
    return report();
  }

  /// The run, its stepper and its state: with the same options, forces and observers, a run that loads this goes on with
  /// the bits that this one goes on with after forget_unsaved(). Of the observers, those that can be archived are.
  template <class Ar>
  void archive(Ar& ar) {
    if constexpr (Ar::reading)
      if (!begun_ && step_.set_up() != Outcome::success)
        throw CheckpointError("phistep: this run can't go on, its options can't work");
    ar("clock", step_.clock());
    ar.state("state", state_);
    ar("stepper", stepper_, "control", step_.pace(), "report", report_, "counts_before", before_, "begun", begun_,
       "ended", ended_, "first", first_, "at_jump", step_.stands_at_jump(), "left_at", edits_, "armed", events_,
       "trust", trust_);
    std::apply([&ar](auto&... observer) { ar(observer...); }, Watchers::kept(observers_));
    if constexpr (FieldState<Plain>) {  // the saved guard knew another vector
      bool unedited = !Ar::reading && edits_.holds(time(), state_);
      ar.aside("unedited", unedited);
      ar.at_last([this, unedited] {
        if (unedited) edits_.remember(time(), state_);
        else edits_.forget();
      });
    }
    // What was done to the stepper before is undone by what it has loaded.
    if constexpr (requires { stepper_.changes(); }) ar.at_last([this] { changes_ = stepper_.changes(); });
  }
  /// As PhiStepper's.
  void forget_unsaved() requires HasUnsaved<Stepper> { stepper_.forget_unsaved(); }

  [[nodiscard]] bool has_ended() const { return ended_; }
  [[nodiscard]] Scalar time() const { return step_.clock().t(); }  ///< [time] where the state stands
  [[nodiscard]] RunReport report() const {
    RunReport report = report_;
    report.t = static_cast<double>(time());
    report.statistics = stepper_.statistics() - before_;
    if constexpr (observed) {  // what states inside steps cost was not done by the stepper itself
      Statistics inside = report_.statistics;
      inside.steps = inside.rejections = 0;
      report.statistics = report.statistics + inside;
    }
    if constexpr (Pace::varies) {
      // Where steps are doubled, the stepper counts three for each try.
      report.statistics.steps = report_.statistics.steps;
      report.statistics.rejections = report_.statistics.rejections;
    }
    return report;
  }

 private:
  using Watchers = ObserverList<S, Observers...>;
  using Pace = decltype(pace_of<S>(std::declval<const Control&>()));
  using Events = decltype(set_of<S>(std::declval<Watchers&>().events()));
  using Found = typename Events::Found;
  static constexpr bool has_events = Watchers::has_events, observed = Watchers::see_steps;
  static constexpr bool minds_edits = Pace::sees_error || has_events;
  static constexpr bool has_inside = std::is_copy_constructible_v<Stepper>;
  static constexpr bool looks_inside = has_inside && Watchers::may_look_inside;
  /// Without observers the stepper does steps of one length in one call.
  static constexpr bool takes_several = facts_of<Stepper>.takes_several && !Pace::varies && sizeof...(Observers) == 0;
  using Attempt = StepAttempt<Stepper, S, Pace, observed>;
  using Look = Only<observed, LookInside<Attempt, looks_inside>>;

  bool step(bool may_be_edited) {
    if constexpr (!FieldState<Plain>) return try_step(may_be_edited);
    else try {
        return try_step(may_be_edited);
      } catch (const ThrownElsewhere&) {
        return end(Outcome::exception_elsewhere);
      }
  }
  bool try_step(bool may_be_edited) {
    if (ended_ || (!begun_ && !begin())) return false;
    if (step_.is_at_end()) return end(Outcome::success);
    const Origin origin = may_be_edited || first_ ? Origin::unknown : Origin::unedited;
    if (minds_edits && origin == Origin::unknown && !take_edits()) return false;
    step_.begin(has_events || (looks_inside && !is_sure_inside<Pace::sees_error>(stepper_)), first_);
    Scalar tried{0};
    for (bool has_failed = false;;) {
      if (!step_.pace().may_try()) return end(Outcome::too_many_steps);
      Landing<Scalar> to = step_.pace().plan(step_.clock(), observers_.next_stop(time(), step_.clock().span().t1));
      const Scalar length = std::abs(to.dt);
      if (tried != 0 && length >= tried)  // the clock knows no shorter one
        return end(has_failed ? report_.failure.outcome : Outcome::step_too_small);
      tried = length;
      Found found;
      StepReport done = step_.attempt(to, origin);
      if constexpr (has_events)
        if (done) {
          edits_.forget();  // if g throws, nothing is known of it
          done = events_.cut(step_, look_, to, found);
        }
      if (failed(found.outcome)) return end(found.outcome);
      if (done) {
        if (has_failed) report_.failure = {};
        return complete(to, found);
      }
      const Outcome outcome = step_.retry(done.outcome(), to, report_.limits);
      // Where shorter and shorter steps fail, why they do is the story.
      if (outcome == Outcome::step_too_small && has_failed) return end(report_.failure.outcome);
      has_failed = done.outcome() != Outcome::error_too_large;
      if (failed(outcome) || has_failed) report_.failure = done.failure();
      if (failed(outcome)) return end(outcome);
      report_.statistics.rejections += has_failed ? 0 : 1;
    }
  }

  /// Does the steps of one length that lie ahead in one call: nothing sees the states between them.
  bool go_on() {
    if constexpr (takes_several) {
      if (ended_) return false;
      const auto steps = step_.pace().ahead(step_.clock());
      if (steps.count() == 0) return true;
      // What has been done when an exception ends it counts.
      const AtExit counts{[this, before = stepper_.statistics().steps] {
        const std::int64_t n = stepper_.statistics().steps - before;
        if (n == 0) return;
        const Landing<Scalar> to = step_.pace().after(n);
        step_.clock().move(to);
        count(to);
      }};
      const StepReport done = stepper_.steps(state_, steps, Origin::unedited);
      if (done) return true;
      report_.failure = done.failure();
      return end(done.outcome());
    } else {
      return true;
    }
  }

  bool begin() {
    if (const Outcome bad = step_.begin_run(); failed(bad)) return end(bad);
    if constexpr (has_events && !Pace::varies)
      if (!step_.pace().suits_events(step_.clock())) return end(Outcome::step_too_small);
    if (!observers_.begin(time(), state_)) return end(Outcome::stopped_by_observer);
    const Outcome armed = events_.begin(time(), state_);
    begun_ = true;  // an exception of the force or of an observer leaves it to be done again
    return !failed(armed) || end(armed);
  }
  /// Where state or stepper are not what the last step left: forgets what was kept of them. False where that ends the run.
  bool take_edits() {
    bool same = edits_.holds(time(), step_.plain());
    if constexpr (requires { stepper_.changes(); })
      same = std::exchange(changes_, stepper_.changes()) == stepper_.changes() && same;
    if (same) return true;
    trust_.forget();
    if constexpr (Pace::sees_error)
      if (!step_.pace().edited(step_.plain())) return end(Outcome::invalid_tolerance);
    const Outcome armed = first_ ? Outcome::success : events_.rearm(time(), state_);
    return !failed(armed) || end(armed);
  }
  void count(const Landing<Scalar>& to) {
    const double length = std::abs(static_cast<double>(to.dt));
    step_.accepted(to, report_.limits);
    first_ = false;
    report_.statistics.steps += to.steps;
    report_.smallest_dt = report_.largest_dt == 0 ? length : std::min(report_.smallest_dt, length);
    report_.largest_dt = std::max(report_.largest_dt, length);
    report_.last_dt = length;
  }
  bool complete(const Landing<Scalar>& to, const Found& found) {
    count(to);
    if constexpr (minds_edits) {
      if (alone_) edits_.forget();
      else edits_.remember(time(), step_.plain());
    }
    bool wanted = true;
    try {
      wanted = show(to.dt);
    } catch (...) {  // a bounce happens, whatever an observer thinks of it
      if (const Outcome happened = happen(found); failed(happened)) end(happened);
      throw;
    }
    if (const Outcome happened = happen(found); failed(happened)) return end(happened);
    if (!wanted) return end(Outcome::stopped_by_observer);
    if constexpr (observed)
      if (failed(look_.outcome())) return end(look_.outcome());
    return true;
  }
  [[nodiscard]] bool show(Scalar dt) {
    if constexpr (observed) {
      if constexpr (!has_events) look_.begin(dt);
      look_.check();
      return observers_.look(
          time(), state_,
          CompletedStep<S, has_inside>{step_.t0(), dt, time(), step_.start(), step_.plain(), look_, step_.middle(),
                                       Times<Scalar>{step_.t0(), dt, step_.origin(true)}, &state_});
    } else {
      return observers_.look(time(), state_, Absent<>{});
    }
  }
  [[nodiscard]] Outcome happen(const Found& found) {
    if (!found) return Outcome::success;
    try {
      return events_.happen(time(), state_);
    } catch (...) {
      edits_.forget();  // the next step evaluates g at its start
      throw;
    }
  }

  /// Ends the run; returns false. After a failure (not: stopped by an observer or event) Jacobian and factors are dropped.
  bool end(Outcome outcome) {
    if (failed(outcome) && outcome != Outcome::stopped_by_observer && outcome != Outcome::stopped_by_event)
      step_.forget_solves();
    if (begun_) step_.end_run();
    ended_ = true;
    if constexpr (FieldState<Plain>)  // a slope outside of steps may have been NaN because its force threw
      if (failed(outcome) && outcome != Outcome::exception_elsewhere &&
          !all_ranks(step_.plain(), !held_exception(stepper_)))
        outcome = Outcome::exception_elsewhere;
    report_.outcome = outcome;
    if constexpr (Pace::varies) report_.failure.is_singular = stepper_.last_solve().is_singular;
    if (outcome == Outcome::invalid_tolerance ||
        (!begun_ && (outcome == Outcome::invalid_step || outcome == Outcome::step_too_small)))
      report_.refused = step_.pace().refused();
    const auto span = step_.clock().span();
    if (outcome == Outcome::invalid_step && !std::isfinite(span.t1 - span.t0))
      report_.refused = {"t1 - t0", static_cast<double>(span.t1 - span.t0)};
    if constexpr (FieldState<Plain>) held_exception(stepper_).rethrow();
    return false;
  }

  Stepper& stepper_;
  S& state_;
  Attempt step_;
  Watchers observers_;
  [[no_unique_address]] Events events_;
  Statistics before_;
  RunReport report_;
  bool begun_ = false, ended_ = false, first_ = true;
  bool alone_ = false;  // no observers: the state cannot be edited between steps
  InterpolantTrust trust_;
  std::int64_t changes_ = 0;
  EditGuard<S, false, false> edits_;
  [[no_unique_address]] Look look_{step_, trust_, report_};
};

/// No run: says why, and nothing else.
template <class Stepper, class S, class Control, class... Observers>
  requires(!CanRun<Stepper, S, Control>)
class Run<Stepper, S, Control, Observers...> {
  static constexpr bool is_state = MutableState<S&>;
  static_assert(StateRefusal<is_state, S>::is_said);
  static_assert(
      !is_state || ControlOf<Control, S>,
      "phistep: say how dt is chosen: fixed(0.1) for steps of 0.1, tolerance{.rtol = 1e-6}, iteration_control{...} "
      "or smaller_of(...)");
  static_assert(!is_state || FitsState<Stepper, S>, "phistep: the stepper was made for a state of another type");

 public:
  Run(Stepper&, S&, typename SpanOf<S>::type, const Control&, Observers&&...) {}
  bool advance() { return false; }
  RunReport finish() { return {}; }
  [[nodiscard]] RunReport report() const { return {}; }
};

template <class Stepper, class S, class Control, class... Observers>
Run(Stepper&, S&&, typename SpanOf<std::remove_reference_t<S>>::type, const Control&, Observers&&...)
    -> Run<Stepper, std::remove_reference_t<S>, Control, Observers...>;

/// Steps `state` from span.t0 to exactly span.t1, forward or backward.
/// @param control    fixed(dt), tolerance{.rtol = 1e-6, .atol = 1e-9}, iteration_control{…} or smaller_of(both)
/// @param observers  called at t0 and after every step as observer(t, state); one that returns false ends the run. An
///                   observer callable as observer(step) sees a CompletedStep instead, from the first step on; begin(t0,
///                   state), if it has that, comes before. at_times and sampled are called at given times, event at roots.
/// @return outcome, time reached, counts; on failure the state is that of the last good step
template <class Stepper, class S, class Control, class... Observers>
  requires(!State<Stepper>)
RunReport integrate(Stepper& stepper, S&& state, typename SpanOf<std::remove_reference_t<S>>::type span,
                    const Control& control, Observers&&... observers) {
  static_assert(StateRefusal<MutableState<S>, std::remove_reference_t<S>>::is_said);
  if constexpr (MutableState<S>)
    return Run<Stepper, std::remove_reference_t<S>, Control, Observers...>{stepper, state, span, control,
                                                                           std::forward<Observers>(observers)...}
        .finish();
  else return {};
}
/// No run: says which header runs without a stepper. (What that header offers is a better match.)
template <State S, class F, class Control, class... Observers>
RunReport integrate(S&, F&&, TimeSpan<std::type_identity_t<ScalarOf<S>>>, const Control&, Observers&&...) {
  static_assert(!sizeof(S),
                "phistep: integrate without a stepper chooses its scheme: it is in <phistep/automatic.hpp>");
  return {};
}
template <State S, class F, class Mass, class Control, class... Observers>
RunReport integrate(S& y, F&& force, const Mass&, TimeSpan<std::type_identity_t<ScalarOf<S>>> span,
                    const Control& control, Observers&&...) {
  return integrate(y, force, span, control);
}
/// No run: says how times are given.
template <class Stepper, class S, class T, class... Rest>
  requires std::is_arithmetic_v<T> RunReport integrate(Stepper&, S&&, T, Rest&&...) {
    static_assert(!std::is_arithmetic_v<T>,
                  "phistep: the times of a run go in braces: integrate(stepper, state, {t0, t1}, fixed(dt))");
    return {};
  }

}}  // namespace phistep::PHISTEP_ABI
