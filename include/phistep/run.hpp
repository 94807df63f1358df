/// @file
/// A run, step by step: stepper × pace × observers. `integrate` is one that goes on to its end.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/control/fixed_step.hpp"
#include "phistep/control/grid_pace.hpp"
#include "phistep/control/iteration_control.hpp"
#include "phistep/control/pace.hpp"
#include "phistep/control/run_report.hpp"
#include "phistep/control/tolerance.hpp"
#include "phistep/core/archive.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/version.hpp"
#include "phistep/observe/completed_step.hpp"
#include "phistep/observe/dense_output.hpp"
#include "phistep/observe/event.hpp"
#include "phistep/observe/event_set.hpp"
#include "phistep/observe/show.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/parts.hpp"
#include "phistep/stepper/edit_guard.hpp"
#include "phistep/stepper/step_doubling.hpp"
#include "phistep/stepper/transaction.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The pace that a control asks for.
template <State S>
[[nodiscard]] ErrorPace<PlainState<S>> pace_of(const tolerance& control) {
  return ErrorPace<PlainState<S>>{control};
}
template <State S>
[[nodiscard]] ErrorPace<PlainState<S>> pace_of(const SmallerOf& control) {
  return ErrorPace<PlainState<S>>{control};
}
template <State S>
[[nodiscard]] IterationPace<PlainState<S>> pace_of(const iteration_control& control) {
  return IterationPace<PlainState<S>>{control};
}

/// A run from span.t0 to exactly span.t1 that stops between steps whenever the caller likes:
///
///     Run run{stepper, state, {0.0, 10.0}, tolerance{.rtol = 1e-6}, observers…};
///     while (run.advance()) …                                  // one accepted step each; edit the state if you must
///     std::cout << run.report();
///
/// It refers to the stepper, the state and those observers that are given as lvalues: they must outlive it.
template <class Stepper, State S, class Control, class... Observers>
class Run {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  Run(Stepper& stepper, S& state, TimeSpan<std::type_identity_t<Scalar>> span, const Control& control,
      Observers&&... observers)
      : stepper_{stepper},
        state_{state},
        span_{span},
        pace_{make_pace(control)},
        observers_{std::forward<Observers>(observers)...},
        events_{std::apply([](auto&... observer) { return tie_events(observer...); }, observers_)},
        before_{stepper.statistics()} {
    t_ = span.t0;
    edits_.forget();
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  /// One step, and what observers make of it. False once the run has ended, with report() telling how.
  bool advance() { return step(true); }
  /// All the way.
  RunReport finish() {
    // From here on, nobody but the observers has the state between steps: where there are none, nobody.
    alone_ = sizeof...(Observers) == 0;
    for (bool edited = true; step(edited);) edited = !alone_;
    return report();
  }

  /// The run, its stepper and its state: with the same options, forces and observers, a run that loads this goes on with
  /// the bits that this one goes on with. Of the observers, those that can be archived are.
  void save(Writer& out) const {
    with_parts(*this, [&out](auto&... part) { save_parts(out, part...); });
  }
  /// @throws CheckpointError, before anything has changed
  template <class Then>
  void load(Reader& in, Then&& then) {
    if (!begun_ && set_up() != Outcome::success)
      throw CheckpointError("phistep: this run can't go on, its options can't work");
    with_parts(*this, [&in, &then](auto&... part) { load_parts(in, then, part...); });
    // What was done to the stepper before is undone by what it has loaded.
    if constexpr (requires { stepper_.changes(); }) changes_ = stepper_.changes();
  }

  [[nodiscard]] bool has_ended() const { return ended_; }
  [[nodiscard]] Scalar time() const { return t_; }  ///< [time] where the state stands
  [[nodiscard]] RunReport report() const {
    RunReport report = report_;
    report.t = static_cast<double>(t_);
    report.statistics = stepper_.statistics() - before_;
    if constexpr (!is_fixed) {
      // Where steps are doubled, the stepper counts three for each try.
      report.statistics.steps = report_.statistics.steps;
      report.statistics.rejections = report_.statistics.rejections;
    }
    return report;
  }

 private:
  static constexpr bool is_fixed = std::is_same_v<Control, FixedStep>;
  static constexpr bool borrowed = !std::is_same_v<S, Plain>;
  static constexpr bool has_events = (EventLike<Observers> || ...);
  static constexpr bool observed = has_events || (observes_steps<std::remove_reference_t<Observers>, S> || ...);

  /// The time as a part: it lies within the span, and what its sum has lost is a rounding of it.
  template <class T>
  struct TimePart {
    T &t, &lost;
    TimeSpan<Scalar> span;
    void save(Writer& out) const { out(t, lost); }
    template <class Then>
    void load(Reader& in, Then&& then) {
      Scalar at{}, off{};
      in(at, off);
      in.check(std::min(span.t0, span.t1) <= at && at <= std::max(span.t0, span.t1));
      in.check(std::abs(off) <= rounding(std::max(std::abs(span.t0), std::abs(span.t1))));
      then();
      t = at, lost = off;
    }
  };
  /// f(every part of a checkpoint …)
  template <class Self, class F>
  static void with_parts(Self& self, F&& f) {
    StatePart<S> state{self.state_};
    TimePart<std::remove_reference_t<decltype((self.t_))>> time{self.t_, self.lost_, self.span_};
    const auto kept = [](auto& observer) {
      using Observer = std::remove_cvref_t<decltype(observer)>;
      if constexpr (Restorable<Observer> || requires(Writer & ar) { observer.archive(ar); }) return std::tie(observer);
      else return std::tuple<>{};
    };
    const auto observers =
        std::apply([&](auto&... observer) { return std::tuple_cat(kept(observer)...); }, self.observers_);
    std::apply(
        [&](auto&... observer) {
          f(self.stepper_, state, self.pace_, time, self.report_, self.before_, self.begun_, self.ended_, self.first_,
            self.doubled_, self.edits_, self.events_, observer...);
        },
        observers);
  }

  [[nodiscard]] static auto make_pace(const Control& control) {
    if constexpr (is_fixed) return GridPace<Scalar>{control};
    else return pace_of<S>(control);
  }
  using Pace = decltype(make_pace(std::declval<const Control&>()));

  /// What one step tries.
  struct Plan {
    Scalar end;            ///< [time] where it lands, the very number
    Scalar dt;             ///< [time] nominal
    bool lands;            ///< `end` is a number given, not t + dt
    bool clipped;          ///< shorter than the pace wanted
    bool is_node = false;  ///< `end` is the next node of a fixed grid
  };

  bool step(bool may_be_edited) {
    if (ended_) return false;
    if (!begun_ && !begin()) return false;
    if (!may_go_on()) return false;
    const Origin origin = may_be_edited || first_ ? Origin::unknown : Origin::unedited;
    if constexpr (sees_error || has_events)
      if (origin == Origin::unknown && !is_as_left())
        if (!take_edits()) return false;
    if constexpr (observed) copy_blocks<S>(start_, state_);
    if constexpr (has_events && can_go_back) before_step_.emplace(stepper_.checkpoint());
    for (bool failed = false;;) {
      if constexpr (!is_fixed)
        if (!pace_.may_try()) return end(Outcome::too_many_steps);
      const Plan plan = this->plan();
      const StepReport done = attempt(plan, origin);
      if (done) {
        if (failed) report_.failure = {};
        return complete(plan);
      }
      if (!may_retry(done, plan)) {
        // Where shorter and shorter steps fail, why they do is the story.
        if (outcome_ == Outcome::step_too_small && failed) return end(report_.failure.outcome);
        report_.failure = done.failure();
        return end(outcome_);
      }
      failed = done.outcome() != Outcome::error_too_large;
      report_.statistics.rejections += failed ? 0 : 1;
      if (failed) report_.failure = done.failure();
    }
  }

  bool begin() {
    if constexpr (is_fixed) {
      if (const Outcome bad = set_up(); bad != Outcome::success) return end(bad);
    } else {
      if (!std::isfinite(span_.t1 - span_.t0)) return end(Outcome::invalid_step);
      if (span_.t1 != span_.t0) {
        if (!is_finite(plain())) return end(Outcome::non_finite_state);
        if (const Outcome bad = set_up(); bad != Outcome::success) return end(bad);
        const auto slope = [this](Scalar t, const Plain& y, Plain& out) { return stepper_.slope(t, y, out); };
        if (const Outcome bad = pace_.start(span_, plain(), stepper_.order(), slope); bad != Outcome::success)
          return end(bad);
      }
    }
    const bool wanted = std::apply([this](auto&... observer) { return (this->greet(observer) && ...); }, observers_);
    if (!wanted) return end(Outcome::stopped_by_observer);
    const Outcome armed = events_.begin(t_, state_);
    begun_ = true;  // an exception of the force or of an observer leaves it to be done again
    return armed == Outcome::success || end(armed);
  }
  /// Somebody may have edited the state: nothing that was known of it holds. False where that ends the run.
  bool take_edits() {
    if constexpr (sees_error)
      if (!pace_.edited(plain())) return end(Outcome::invalid_tolerance);
    const Outcome armed = first_ ? Outcome::success : events_.rearm(t_, state_);
    return armed == Outcome::success || end(armed);
  }
  /// All that begins a run but force calls.
  [[nodiscard]] Outcome set_up() {
    if constexpr (is_fixed) {
      return pace_.begin(span_);
    } else {
      return pace_.begin(span_, plain(), error_law());
    }
  }
  template <class Observer>
  [[nodiscard]] bool greet(Observer& observer) {
    if constexpr (requires { observer.begin(t_, state_); }) {
      if constexpr (std::is_void_v<decltype(observer.begin(t_, state_))>) observer.begin(t_, state_);
      else if (!observer.begin(t_, state_)) return false;
    }
    if constexpr (observes_steps<Observer, S> || EventLike<Observer>) return true;
    else return show(observer, t_, state_);
  }

  [[nodiscard]] bool may_go_on() {
    if constexpr (is_fixed) return !pace_.at_end() || end(Outcome::success);
    else return t_ != span_.t1 || end(Outcome::success);
  }

  [[nodiscard]] Plan plan() const {
    const Scalar sign = span_.t1 < span_.t0 ? Scalar{-1} : Scalar{1};
    if constexpr (is_fixed) {
      const Scalar node = pace_.end();
      const std::optional<Scalar> stop = next_stop(sign);
      // A stop that rounding alone keeps from a node is that node, unless that is the end.
      const Scalar beyond = stop ? sign * (node - *stop) : Scalar{-1};
      const Scalar same = node == span_.t1 ? Scalar{0} : rounding(node);
      if (beyond > same) return {*stop, *stop - t_, true, true};
      return {stop && -beyond <= same ? *stop : node, pace_.length(t_), true, false, true};
    } else {
      const Scalar stop = next_stop(sign).value_or(span_.t1);
      const Scalar left = sign * (stop - t_), wanted = static_cast<Scalar>(pace_.propose());
      // A stretch by a hundredth spares a tiny last step; two halves are better than one step and a bit.
      const Scalar stretched = std::min(static_cast<Scalar>(1.01) * wanted, static_cast<Scalar>(pace_.longest()));
      if (left <= std::max(wanted, stretched) + rounding(stop)) return {stop, stop - t_, true, wanted > left};
      if (left < 2 * wanted) return {t_ + sign * left / 2, sign * left / 2, false, true};
      return {t_ + sign * wanted, sign * wanted, false, false};
    }
  }
  /// Times this near each other are one.
  [[nodiscard]] static Scalar rounding(Scalar t) { return 8 * std::numeric_limits<Scalar>::epsilon() * std::abs(t); }
  /// The nearest of all times at which somebody wants the run to stop, its end included.
  [[nodiscard]] std::optional<Scalar> next_stop(Scalar sign) const {
    std::optional<Scalar> nearest;
    const auto consider = [&](const auto& observer) {
      if constexpr (requires { observer.next_stop(t_, sign); }) {
        const std::optional<Scalar> stop = observer.next_stop(t_, sign);
        if (stop && sign * (*stop - t_) > 0 && sign * (span_.t1 - *stop) > 0 &&
            (!nearest || sign * (*nearest - *stop) > 0))
          nearest = stop;
      }
    };
    std::apply([&](const auto&... observer) { (consider(observer), ...); }, observers_);
    return nearest;
  }

  [[nodiscard]] StepReport attempt(const Plan& plan, Origin origin) {
    if constexpr (sees_error) {
      auto& trace = pace_.trace();
      pace_.prepare(plain());
      trace.wants_dense = observed;
      traced_ = false;
      // Between stops a rounding apart there is no error to be seen, and no half way.
      if (plan.lands && std::abs(plan.dt) <= rounding(t_)) return plain_step(plan, origin);
      const auto accept = [this](const Plain& y, const Plain& next, const auto& told) {
        return pace_.judge(y, next, told.error);
      };
      if constexpr (can_trace<Stepper>)
        if (stepper_.estimates(trace)) {
          doubled_ = false;
          traced_ = true;
          return stepper_.attempt(state_, t_, plan.dt, origin, trace, accept);
        }
      doubled_ = true;
      return doubling_.attempt(stepper_, state_, t_, plan.dt, origin, trace, accept);
    } else {
      return plain_step(plan, origin);
    }
  }
  [[nodiscard]] StepReport plain_step(const Plan& plan, Origin origin) {
    if constexpr (requires { stepper_.step(state_, t_, plan.dt, origin); })
      return stepper_.step(state_, t_, plan.dt, origin);
    else return stepper_.step(state_, t_, plan.dt);
  }
  /// Whether state and stepper are what the last step left.
  [[nodiscard]] bool is_as_left() {
    bool same = edits_.holds(t_, plain());
    if constexpr (requires { stepper_.changes(); }) {
      same = same && changes_ == stepper_.changes();
      changes_ = stepper_.changes();
    }
    return same;
  }
  /// After a step that failed: whether the pace has a shorter one. Else outcome_ says how the run ends.
  [[nodiscard]] bool may_retry(const StepReport& done, const Plan& plan) {
    outcome_ = done.outcome();
    if constexpr (!is_fixed) {
      outcome_ =
          pace_.failed(done.outcome(), std::abs(static_cast<double>(plan.dt)), stepper_.history(), report_.limits);
      return outcome_ == Outcome::success;
    }
    return false;
  }

  /// The step has become the state.
  bool complete(const Plan& plan) {
    const Scalar from = t_;
    [[maybe_unused]] const Scalar lost = lost_;
    slopes_are_finite_ = true;
    if constexpr (is_fixed) {
      t_ = plan.end;
    } else {
      pace_.accepted(std::abs(static_cast<double>(plan.dt)), plan.clipped, stepper_.history(), report_.limits);
      move_time(plan);
    }
    Scalar dt = plan.dt;
    [[maybe_unused]] typename EventsAmong<S, Observers...>::Found found;
    if constexpr (has_events) {
      try {
        found = find_event(from, dt);
        if (found.outcome != Outcome::success) return end(found.outcome);
        if (found && !go_to(found, from, dt)) return end(outcome_);
        if (found) events_.look(found, t_, state_);
        if (!slopes_are_finite_) {  // where g passes zero between the step's ends, they say
          go_back<true>(from);
          return end(Outcome::non_finite_force);
        }
      } catch (...) {  // of g, or of the force: there was no step
        go_back<true>(from);
        lost_ = lost;
        edits_.forget();  // nor is anything known of it
        throw;
      }
    }
    if constexpr (is_fixed)
      if (plan.is_node && t_ == plan.end) pace_.reached(t_);
    first_ = false;
    const double length = std::abs(static_cast<double>(dt));
    ++report_.statistics.steps;
    report_.smallest_dt = report_.largest_dt == 0 ? length : std::min(report_.smallest_dt, length);
    report_.largest_dt = std::max(report_.largest_dt, length);
    if constexpr (sees_error || has_events) {
      if (cut_ || alone_) edits_.forget();
      else edits_.remember(t_, plain());
    }
    if constexpr (has_events) {
      const auto happen = [&] {
        if (!found) return Outcome::success;
        try {
          return events_.happen(t_, state_);
        } catch (...) {
          edits_.forget();  // the next step looks where g stands
          throw;
        }
      };
      bool wanted = true;
      try {
        wanted = watch(from, dt);
      } catch (...) {  // a bounce happens, whatever an observer thinks of it
        if (const Outcome happened = happen(); happened != Outcome::success) end(happened);
        throw;
      }
      if (const Outcome happened = happen(); happened != Outcome::success) return end(happened);
      return (wanted || end(Outcome::stopped_by_observer)) && has_shown();
    } else {
      return (watch(from, dt) || end(Outcome::stopped_by_observer)) && has_shown();
    }
  }
  /// Whoever looked inside the step has seen what is no number, if its slopes are none.
  [[nodiscard]] bool has_shown() { return slopes_are_finite_ || end(Outcome::non_finite_force); }

  /// The first event of the step just done. Where some g is not finite, there was no step.
  [[nodiscard]] auto find_event(Scalar from, Scalar dt) {
    cut_ = false;
    const auto slopes = [this, from](Plain& at_start, Plain& at_end) { know_slopes(from, at_start, at_end); };
    begin_dense(from, dt, slopes);
    const auto found = events_.find(CompletedStep<S>{from, dt, t_, start_, plain(), dense_});
    if (found.outcome != Outcome::success) go_back(from);
    return found;
  }
  /// Does the step again, up to the event. False where it fails, with outcome_: the state is then that of the start.
  [[nodiscard]] bool go_to(const auto& found, Scalar from, Scalar& dt) {
    outcome_ = Outcome::non_finite_event;
    const auto hit = events_.refine(found, [&](Scalar t) -> const Plain* {
      go_back(from);
      const StepReport done = stepper_.step(state_, from, t - from);
      if (done) return &plain();
      report_.failure = done.failure();
      outcome_ = done.outcome();
      return nullptr;
    });
    if (!std::isfinite(hit.g)) {
      go_back(from);
      return false;
    }
    if (hit.resteps == 0) return true;
    cut_ = true;
    t_ = hit.t;
    lost_ = Scalar{0};
    dt = t_ - from;
    return true;
  }
  /// @tparam for_good  nobody goes back another time: then nothing is allocated
  template <bool for_good = false>
  void go_back(Scalar from) {
    copy_blocks<S>(state_, start_);
    t_ = from;
    if constexpr (can_go_back && for_good) stepper_.restore(std::move(*before_step_));
    else if constexpr (can_go_back) stepper_.restore(*before_step_);
  }
  /// t + Δt by a compensated sum (W. Kahan, Comm. ACM 8 (1965) 40), or the number to land on.
  void move_time(const Plan& plan) {
    if (plan.lands) {
      t_ = plan.end;
      lost_ = Scalar{0};
      return;
    }
    const Scalar by = plan.dt - lost_, sum = t_ + by;
    lost_ = (sum - t_) - by;
    t_ = sum;
  }

  [[nodiscard]] bool watch(Scalar from, Scalar dt) {
    if constexpr (observed) {
      const auto slopes = [this, from](Plain& at_start, Plain& at_end) { know_slopes(from, at_start, at_end); };
      begin_dense(from, dt, slopes);
      const Plain* middle = nullptr;
      if constexpr (sees_error)
        if (doubled_ && !cut_) middle = &doubling_.middle();
      const CompletedStep<S> step{from, dt, t_, start_, plain(), dense_, middle};
      return std::apply([&](auto&... observer) { return (watch_with(observer, step) && ...); }, observers_);
    } else {
      return std::apply([&](auto&... observer) { return (show(observer, t_, state_) && ...); }, observers_);
    }
  }
  /// The step just done, for whoever looks inside: by the scheme's own interpolant where it has one.
  void begin_dense(Scalar from, Scalar dt, const auto& slopes) {
    dense_.begin(from, dt, t_, start_, plain(), DenseOutput<S>::Slopes::of(slopes));
    if constexpr (interpolates)
      if (traced_ && !cut_)
        dense_.interpolate_by(
            &stepper_, [](const void* stepper, Scalar x, Scalar h, const Plain& y0, const Plain& y1, Plain& out) {
              static_cast<const Stepper*>(stepper)->interpolate(x, h, y0, y1, out);
            });
  }
  template <class Observer>
  [[nodiscard]] bool watch_with(Observer& observer, const CompletedStep<S>& step) {
    if constexpr (EventLike<Observer>) return true;
    else if constexpr (observes_steps<Observer, S>) return ask(observer, step);
    else return show(observer, t_, state_);
  }
  /// Slopes at both ends of the step just done: the scheme's own where it told them, else two force calls.
  void know_slopes(Scalar from, Plain& at_start, Plain& at_end) {
    if constexpr (sees_error)
      if (pace_.trace().dt_before != 0 && !doubled_ && !cut_) {
        copy_blocks<S>(at_start, pace_.trace().before);
        copy_blocks<S>(at_end, pace_.trace().start);
        return;
      }
    slopes_are_finite_ = stepper_.slope(from, start_, at_start) && slopes_are_finite_;
    slopes_are_finite_ = stepper_.slope(t_, plain(), at_end) && slopes_are_finite_;
  }

  /// The state as the stepper's own type: a Map's is gathered.
  [[nodiscard]] const Plain& plain() {
    if constexpr (borrowed) {
      copy_blocks<S>(gathered_, state_);
      return gathered_;
    } else {
      return state_;
    }
  }
  [[nodiscard]] static bool is_finite(const Plain& y) { return !first_non_finite(Blocks<S>::all(y)); }
  [[nodiscard]] ErrorLaw error_law() const {
    ErrorLaw law{stepper_.order(), stepper_.order() + 1, dead_band(), StepFilter::H211b};
    if constexpr (requires { stepper_.error_order(); }) law.error_order = stepper_.error_order();
    if constexpr (requires { requires Stepper::refactorises; }) law.filter = StepFilter::predictive;
    else if (law.dead_band > 1) law.filter = StepFilter::PI42;
    else if (law.order >= 6) law.filter = StepFilter::predictive;  // where Δt changes by a fifth, errors do by a decade
    return law;
  }
  /// By how much Δt has to grow to be worth new factors: without a matrix, at once; Newton makes do with old ones within
  /// limits; an affine step can't, and a factorisation is then most of what it costs.
  [[nodiscard]] double dead_band() const {
    if constexpr (requires { requires Stepper::refactorises; }) return 1;
    if constexpr (requires { stepper_.solver_name(); })
      if (const std::string_view name{stepper_.solver_name()}; name == "none" || name == "fixed-point iteration")
        return 1;
    if constexpr (requires { requires Stepper::is_affine; }) return 2;
    else return 1.2;
  }
  bool end(Outcome outcome) {
    ended_ = true;
    report_.outcome = outcome;
    return false;
  }
  static constexpr bool sees_error = [] {
    if constexpr (is_fixed) return false;
    else return Pace::sees_error;
  }();
  static constexpr bool interpolates = sees_error && requires { requires Stepper::interpolates; };
  struct Nothing {};
  static constexpr bool can_go_back = requires(Stepper & stepper) { stepper.restore(stepper.checkpoint()); };
  static auto checkpoint_of() {
    if constexpr (has_events && can_go_back) return std::optional<decltype(std::declval<Stepper&>().checkpoint())>{};
    else return Nothing{};
  }

  Stepper& stepper_;
  S& state_;
  TimeSpan<Scalar> span_;
  Pace pace_;
  std::tuple<Observers...> observers_;
  [[no_unique_address]] EventsAmong<S, Observers...> events_;
  Statistics before_;
  Scalar t_, lost_{0};
  RunReport report_;
  Outcome outcome_ = Outcome::success;
  bool begun_ = false, ended_ = false, first_ = true, doubled_ = false, traced_ = false;
  bool cut_ = false;               // the step just done is shorter than the one accepted: it ends at an event
  bool alone_ = false;             // nobody has the state between steps
  bool slopes_are_finite_ = true;  // of the step just done, as far as somebody asked
  std::int64_t changes_ = 0;
  EditGuard<S, false, false> edits_;
  [[no_unique_address]] std::conditional_t<sees_error, StepDoubling<Stepper, S>, Nothing> doubling_;
  [[no_unique_address]] std::conditional_t<observed, Plain, Nothing> start_;
  [[no_unique_address]] decltype(checkpoint_of()) before_step_;
  [[no_unique_address]] std::conditional_t<borrowed, Plain, Nothing> gathered_;
  [[no_unique_address]] std::conditional_t<observed, DenseOutput<S>, Nothing> dense_;
};

template <class Stepper, State S, class Control, class... Observers>
Run(Stepper&, S&, TimeSpan<std::type_identity_t<ScalarOf<S>>>, const Control&, Observers&&...)
    -> Run<Stepper, S, Control, Observers...>;

}  // namespace phistep::inline PHISTEP_ABI
