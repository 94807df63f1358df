/// @file
/// A run, step by step: stepper × pace × observers. `integrate` is one that goes on to its end.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/control/control_of.hpp"
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
#include "phistep/force/evaluate.hpp"
#include "phistep/observe/completed_step.hpp"
#include "phistep/observe/dense_output.hpp"
#include "phistep/observe/event.hpp"
#include "phistep/observe/event_set.hpp"
#include "phistep/observe/interpolant_trust.hpp"
#include "phistep/observe/show.hpp"
#include "phistep/problem/edit_guard.hpp"
#include "phistep/problem/kernel.hpp"
#include "phistep/problem/transaction.hpp"
#include "phistep/schemes/extrapolation/extrapolation.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/parts.hpp"
#include "phistep/step/error_law.hpp"
#include "phistep/step/parts_inside.hpp"
#include "phistep/step/step_doubling.hpp"
#include "phistep/step/step_inside.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Whether the stepper may have been made for a state of this type.
template <class Stepper, class S>
inline constexpr bool fits_state = true;
template <class Stepper, class S>
  requires requires { typename Stepper::StateType; }
inline constexpr bool fits_state<Stepper, S> = std::is_same_v<typename Stepper::StateType, S>;
/// The times of a run; of no state, to be refused later.
template <class S>
struct SpanOf {
  using type = TimeSpan<double>;
};
template <State S>
struct SpanOf<S> {
  using type = TimeSpan<ScalarOf<S>>;
};

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
  static constexpr const char* part_name = "run";

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
    // From here on only observers can edit the state between steps.
    alone_ = sizeof...(Observers) == 0;
    for (bool edited = true; step(edited);) edited = !alone_;
    return report();
  }

  /// The run, its stepper and its state: with the same options, forces and observers, a run that loads this goes on with
  /// the bits that this one goes on with after forget_unsaved(). Of the observers, those that can be archived are.
  void save(Writer& out) const {
    with_parts(*this, [&out](auto&... part) { save_parts(out, part...); });
  }
  /// As PhiStepper's.
  void forget_unsaved() requires HasUnsaved<Stepper> { stepper_.forget_unsaved(); }
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
    if constexpr (observed) {  // what it cost to look inside of steps was not done by the stepper itself
      Statistics inside = report_.statistics;
      inside.steps = inside.rejections = 0;
      report.statistics = report.statistics + inside;
    }
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
    void save(Writer& out) const { out("t", t, "lost", lost); }
    template <class Then>
    void load(Reader& in, Then&& then) {
      Scalar at{}, off{};
      in("t", at, "lost", off);
      in.check(std::min(span.t0, span.t1) <= at && at <= std::max(span.t0, span.t1));
      const Scalar largest = std::max(std::abs(span.t0), std::abs(span.t1));
      in.check(std::abs(off) <= 2 * std::numeric_limits<Scalar>::epsilon() * largest);
      then();
      t = at, lost = off;
    }
  };
  /// f(every part of a checkpoint …)
  template <class Self, class F>
  static void with_parts(Self& self, F&& f) {
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
          f("clock", time, "state", self.state_, "stepper", self.stepper_, "control", self.pace_, "report",
            self.report_, "counts_before", self.before_, "begun", self.begun_, "ended", self.ended_, "first",
            self.first_, "left_at", self.edits_, "armed", self.events_, "trust", self.trust_, "parts_trust",
            self.parts_trust_, observer...);
        },
        observers);
  }

  [[nodiscard]] static auto make_pace(const Control& control) {
    if constexpr (is_fixed) return GridPace<Scalar>{control};
    else return pace_of<S>(control);
  }
  using Pace = decltype(make_pace(std::declval<const Control&>()));

  /// How a step was tried: without a look at its error, by a scheme that tells of its error, or in two halves.
  enum class Way { plain, traced, doubled };
  /// Where a step starts: what go_back() restores.
  struct Start {
    Scalar t, lost;
  };
  using Found = typename EventsAmong<S, Observers...>::Found;
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
    if constexpr (keeps_past)
      if (has_events || !hermite_is_enough()) before_step_.emplace(stepper_.checkpoint());
    const Start start{t_, lost_};
    for (bool failed = false;;) {
      if constexpr (!is_fixed)
        if (!pace_.may_try()) return end(Outcome::too_many_steps);
      Plan plan = this->plan();
      Found found;
      StepReport done = attempt(plan, origin);
      if (done) {
        move_time(plan);
        if constexpr (has_events) done = cut_at_event(plan, start, found);
        if (ended_) return false;
      }
      if (done) {
        if (failed) report_.failure = {};
        return complete(plan, start.t, found);
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
        const auto slope = [this](Scalar t, const Plain& y, Plain& out) { return this->slope(t, y, out); };
        if (const Outcome bad = pace_.start(span_, plain(), stepper_.order(), slope); bad != Outcome::success)
          return end(bad == Outcome::non_finite_force ? bad_slope_ : bad);
      }
    }
    const bool wanted = std::apply([this](auto&... observer) { return (this->greet(observer) && ...); }, observers_);
    if (!wanted) return end(Outcome::stopped_by_observer);
    const Outcome armed = events_.begin(t_, state_);
    begun_ = true;  // an exception of the force or of an observer leaves it to be done again
    return armed == Outcome::success || end(armed);
  }
  /// After a possible edit of the state: forgets what was kept of it. False where that ends the run.
  bool take_edits() {
    trust_.forget();
    parts_trust_.forget();
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
      return pace_.begin(span_, plain(), error_law(stepper_));
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
      if (beyond > same) return {*stop, pace_.length(t_, *stop), true, true};
      return {stop && -beyond <= same ? *stop : node, pace_.length(t_), true, false, true};
    } else {
      const Scalar stop = next_stop(sign).value_or(span_.t1);
      const Scalar left = sign * (stop - t_ + lost_), wanted = static_cast<Scalar>(pace_.propose());
      // A stretch by a hundredth spares a tiny last step; two halves are better than one step and a bit.
      const Scalar stretched = std::min(static_cast<Scalar>(1.01) * wanted, static_cast<Scalar>(pace_.longest()));
      if (left <= std::max(wanted, stretched) + rounding(stop)) return {stop, sign * left, true, wanted > left};
      if (left < 2 * wanted) return {t_ + sign * left / 2, sign * left / 2, false, true};
      return {t_ + sign * wanted, sign * wanted, false, false};
    }
  }
  /// Times this near each other are one: by so much nodes and given times are off their numbers.
  [[nodiscard]] Scalar rounding(Scalar t) const {
    return std::numeric_limits<Scalar>::epsilon() * (std::abs(t) + std::abs(t - span_.t0));
  }
  /// The nearest of all times at which an observer wants the run to stop.
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
    way_ = Way::plain;
    if constexpr (sees_error) {
      auto& trace = pace_.trace();
      pace_.prepare(plain(), std::abs(static_cast<double>(plan.dt)));
      trace.wants_dense = observed;
      // A step of a few ticks of the clock, where far longer ones are within the tolerance, tells of rounding alone.
      const double length = std::abs(static_cast<double>(plan.dt));
      if (plan.lands && length <= static_cast<double>(rounding(t_)) && 100 * length <= pace_.propose())
        return plain_step(plan, origin);
      const auto accept = [this](const Plain& y, const Plain& next, const auto& told) {
        return pace_.judge(y, next, told.error);
      };
      if constexpr (can_trace<Stepper>)
        if (stepper_.estimates(trace)) {
          way_ = Way::traced;
          return stepper_.attempt(state_, t_, plan.dt, origin, trace, accept);
        }
      // Neighbouring floating-point times have no midpoint: the step cannot be halved.
      if (const Scalar middle = t_ + plan.dt / 2; middle == t_ || middle == t_ + plan.dt)
        return plain_step(plan, origin);
      const StepReport done = doubling_.attempt(stepper_, state_, t_, plan.dt, origin, trace, accept);
      if (done) way_ = Way::doubled;
      return done;
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
  bool complete(const Plan& plan, Scalar from, [[maybe_unused]] const Found& found) {
    const Scalar dt = plan.dt;
    if constexpr (!is_fixed)
      pace_.accepted(std::abs(static_cast<double>(dt)), plan.clipped, stepper_.history(), report_.limits);
    if constexpr (is_fixed)
      if (plan.is_node) pace_.reached(t_);
    first_ = false;
    const double length = std::abs(static_cast<double>(dt));
    ++report_.statistics.steps;
    report_.smallest_dt = report_.largest_dt == 0 ? length : std::min(report_.smallest_dt, length);
    report_.largest_dt = std::max(report_.largest_dt, length);
    if constexpr (sees_error || has_events) {
      if (alone_) edits_.forget();
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
  /// False, and the run ends, where a state inside the step was asked for and its slopes or the step to it failed.
  [[nodiscard]] bool has_shown() {
    if (looked_ != Outcome::success) return end(looked_);
    return slopes_are_finite_ || end(bad_slope_);
  }

  /// Ends the step just done at its first event, if there is one: it is done again, shorter, and is then a step like any
  /// other, of the same scheme and with the same error test, which may refuse it. Where there was no step after all, the
  /// state and the stepper are those of its start; or else the run has ended.
  [[nodiscard]] StepReport cut_at_event(Plan& plan, const Start& start, Found& found) {
    try {
      begin_looks(start.t, plan.dt);
      const CompletedStep<S> step{start.t, plan.dt, t_, start_, plain(), dense_};
      found = events_.find(step);
      // Where the interpolant is far off, it may have roots of its own: then the search is done by real steps.
      if constexpr (sees_error && looks_inside)
        if ((found || found.outcome != Outcome::success) && found.root.t != t_ && !hermite_is_enough()) {
          const bool trusted = trusts_interpolant(start.t, plan.dt);
          dense_.check_by(DenseOutput<S>::Truth::of(look_), trusted);
          if (!trusted) found = events_.find(step);
        }
      StepReport done{Outcome::success, 0, nullptr};
      if (found) done = go_to(found, plan, start);
      if (!done) return done;
      if (found) events_.look(found, t_, state_);
      if (found.outcome != Outcome::success) end(found.outcome);
      else static_cast<void>(has_shown());  // where g passes zero inside the step, slopes that are none say so
      if (ended_) go_back(start);
      return done;
    } catch (...) {  // of g, or of the force: there was no step
      go_back<true>(start);
      edits_.forget();  // nor is anything known of it
      forget_solves();
      throw;
    }
  }
  /// Does the step again, up to the event.
  [[nodiscard]] StepReport go_to(Found& found, Plan& plan, const Start& start) {
    StepReport done{Outcome::success, 0, nullptr};
    Plan shorter = plan;
    const auto hit = events_.refine(found, [&](Scalar t) -> const Plain* {
      go_back(start);
      shorter = plan;
      if (t != plan.end || !plan.lands) shorter = {t, length_to(t), true, true};
      done = attempt(shorter, Origin::unknown);
      if (!done) return nullptr;
      move_time(shorter);
      return &plain();
    });
    if (done && hit.resteps > 0) begin_dense(start.t, shorter.dt);
    if (done && !std::isfinite(hit.g)) found.outcome = Outcome::non_finite_event;
    if (hit.resteps > 0) plan = shorter;
    if (!done) go_back(start);
    return done;
  }
  /// From where the run stands to t.
  [[nodiscard]] Scalar length_to(Scalar t) const {
    if constexpr (is_fixed) return pace_.length(t_, t);
    else return t - t_ + lost_;
  }
  /// @tparam for_good  the last time that this step is undone: the checkpoint is moved, nothing is allocated
  template <bool for_good = false>
  void go_back(const Start& start) {
    copy_blocks<S>(state_, start_);
    t_ = start.t;
    lost_ = start.lost;
    if constexpr (sees_error)
      if (std::exchange(way_, Way::plain) == Way::doubled) pace_.trace().step_back();
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
      if constexpr (!has_events) begin_looks(from, dt);
      const Plain* middle = nullptr;
      if constexpr (sees_error)
        if (way_ == Way::doubled) middle = &doubling_.middle();
      if constexpr (looks_inside)
        if (!hermite_is_enough() && !dense_.is_checked()) dense_.check_by(DenseOutput<S>::Truth::of(look_));
      const CompletedStep<S, looks> step{from, dt, t_, start_, plain(), dense_, middle};
      return std::apply([&](auto&... observer) { return (watch_with(observer, step) && ...); }, observers_);
    } else {
      return std::apply([&](auto&... observer) { return (show(observer, t_, state_) && ...); }, observers_);
    }
  }
  /// After a step: no state inside it has been asked for.
  void begin_looks(Scalar from, Scalar dt) {
    slopes_are_finite_ = true;
    looked_ = Outcome::success;
    if constexpr (looks_inside) inside_.reset(), parts_.reset(), looks_ = 0;
    trust_.step();
    parts_trust_.step();
    begin_dense(from, dt);
  }
  /// Prepares dense output of the step just done, by the scheme's own interpolant where it has one.
  void begin_dense(Scalar from, Scalar dt) {
    look_ = {this, from, dt};
    const auto fill = [](void* self, Plain& at_start, Plain& at_end) {
      static_cast<Run*>(self)->know_slopes(at_start, at_end);
    };
    dense_.begin(from, dt, t_, start_, plain(), {this, fill});
    if constexpr (interpolates)
      if (way_ == Way::traced)
        dense_.interpolate_by(
            &stepper_, [](const void* stepper, Scalar x, Scalar h, const Plain& y0, const Plain& y1, Plain& out) {
              static_cast<const Stepper*>(stepper)->interpolate(x, h, y0, y1, out);
            });
  }
  template <class Observer>
  [[nodiscard]] bool watch_with(Observer& observer, const auto& step) {
    if constexpr (EventLike<Observer>) return true;
    else if constexpr (observes_steps<Observer, S>) return ask(observer, step);
    else return show(observer, t_, state_);
  }

  /// Checks states inside the step just done by steps that end there.
  struct LookInside {
    Run* run = nullptr;
    Scalar from{}, dt{};
    [[nodiscard]] bool trusts() { return run->trusts_interpolant(from, dt); }
    void operator()(Scalar t, Plain& out) {
      if (!run->go_by_parts(from, dt, t, out)) run->really_go(from, t - from, out);
    }
  };
  /// Hermite's interpolant has an error of Δt⁴: less than steps of order 1 and 2 leave, unless a stiff component makes large
  /// slopes of small errors.
  [[nodiscard]] bool hermite_is_enough() const {
    if constexpr (requires { requires Stepper::solves_nothing; }) return stepper_.order() <= 2;
    else return false;
  }
  /// Whether the interpolant is right to half the tolerance, at two places where steps are done to learn it. (At one alone
  /// its error may pass zero.) At a fixed Δt there is no tolerance to compare with: always false.
  [[nodiscard]] bool trusts_interpolant(Scalar from, Scalar dt) {
    if constexpr (!sees_error) {
      return false;
    } else {
      const double length = std::abs(static_cast<double>(dt));
      if (const std::optional<bool> known = trust_.known(length)) return *known;
      double worst = 0;
      for (const double x : doubtful_places) {
        if (!(worst <= 0.5)) break;
        const Scalar t = from + static_cast<Scalar>(x) * dt;
        copy_blocks<S>(off_, start_);
        if (!really_go(from, t - from, off_)) return true;  // the run ends for it
        for_each_block([](auto, auto& to, const auto& by) { to -= by; }, Blocks<S>::all(off_),
                       Blocks<S>::all(dense_.interpolated(t)));
        const double size = pace_.size(start_, plain(), off_);
        worst = size <= worst ? worst : size;  // NaN, too
      }
      return trust_.check(length, worst);
    }
  }
  /// out = y(t) by the interpolants of parts of the step just done, from the third state on that is asked for. False where
  /// these are not right either.
  bool go_by_parts(Scalar from, Scalar dt, Scalar t, Plain& out) {
    if constexpr (!sees_error || !looks_inside) {
      return false;
    } else {
      const int parts = trust_.parts();
      const Scalar length = dt / static_cast<Scalar>(std::max(parts, 1));
      const auto size = std::abs(static_cast<double>(length));
      if (++looks_ <= 2 || parts == 0 || parts_trust_.known(size) == false) return false;
      if (!parts_ || parts_->is_past(t)) {
        if constexpr (can_go_back) parts_.emplace(stepper_, *before_step_, start_, from, dt, parts, pace_.trace());
        else parts_.emplace(stepper_, Nothing{}, start_, from, dt, parts, pace_.trace());
      }
      const auto at = [&](Scalar time, Plain& to) {
        const Statistics spent = parts_->spent();
        copy_blocks<S>(end_, state_);
        const auto leave = [&] { this->leave(parts_->spent() - spent); };
        try {
          const bool is_done = parts_->at(
              state_, time, to,
              [this](const Plain& y, const Plain& next, const Plain& error) { return pace_.allows(y, next, error); });
          leave();
          return is_done;
        } catch (...) {
          leave();
          throw;
        }
      };
      if (!parts_trust_.known(size)) {
        double worst = 0;
        for (const double x : doubtful_places) {
          const Scalar place = from + static_cast<Scalar>(x) * length;
          if (!at(place, off_) || !really_go(from, place - from, out)) return false;
          for_each_block([](auto, auto& to, const auto& by) { to -= by; }, Blocks<S>::all(off_), Blocks<S>::all(out));
          const double error = pace_.size(start_, plain(), off_);
          worst = error <= worst ? worst : error;  // NaN, too
        }
        if (!parts_trust_.check(size, worst)) return false;
      }
      return at(t, out);
    }
  }
  /// The state is again that at the step's end, and what it has cost to leave it is counted.
  void leave(Statistics cost) {
    copy_blocks<S>(state_, end_);
    cost.steps = cost.failed_steps = cost.rejections = 0;
    report_.statistics = report_.statistics + cost;
  }
  /// out = y(from + dt) by a step from the start of the one just done. False where it fails, and the run ends with that.
  bool really_go(Scalar from, Scalar dt, Plain& out) {
    if (std::abs(dt) <= rounding(from)) {  // no step, and nothing to tell its ends apart
      copy_blocks<S>(out, dense_.interpolated(from + dt));
      return true;
    }
    if constexpr (can_go_back) {
      if (!inside_) inside_.emplace(stepper_, *before_step_);
    } else if (!inside_) {
      inside_.emplace(stepper_, typename StepInside<Stepper, S>::NoPast{});
    }
    const Statistics spent = inside_->spent();
    copy_blocks<S>(end_, state_);
    const auto leave = [&] { this->leave(inside_->spent() - spent); };
    copy_blocks<S>(state_, start_);
    try {
      const StepReport done = [&] {
        if constexpr (!sees_error) {
          return inside_->step(state_, from, dt);
        } else {
          const auto accept = [this](const Plain& y, const Plain& next, const Plain& error) {
            return pace_.allows(y, next, error);
          };
          return inside_->step(state_, from, dt, pace_.trace(), accept);
        }
      }();
      copy_blocks<S>(out, state_);
      if (!done && looked_ == Outcome::success) {
        looked_ = done.outcome();
        report_.failure = done.failure();
      }
      leave();
      return static_cast<bool>(done);
    } catch (...) {
      leave();
      throw;
    }
  }
  /// Slopes at both ends of the step just done: the scheme's own where it told them, else two force calls.
  void know_slopes(Plain& at_start, Plain& at_end) {
    if constexpr (sees_error)
      if (way_ == Way::traced) {
        const auto& trace = pace_.trace();
        if (trace.has_slopes || trace.dt_before != 0) {  // not yet, or already what the next step starts from
          copy_blocks<S>(at_start, trace.has_slopes ? trace.start : trace.before);
          copy_blocks<S>(at_end, trace.has_slopes ? trace.end : trace.start);
          return;
        }
      }
    slopes_are_finite_ = slope(look_.from, start_, at_start) && slopes_are_finite_;
    slopes_are_finite_ = slope(t_, plain(), at_end) && slopes_are_finite_;
  }
  /// By a force call. False, with bad_slope_: it is no slope.
  [[nodiscard]] bool slope(Scalar t, const Plain& y, Plain& out) {
    bad_slope_ = Outcome::non_finite_force;
    try {
      return stepper_.slope(t, y, out);
    } catch (const WrongSize&) {
      bad_slope_ = Outcome::wrong_size;
      for_each_block([](auto, auto& block) { block.setConstant(std::numeric_limits<Scalar>::quiet_NaN()); },
                     Blocks<S>::all(out));
      return false;
    }
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
  /// Where a run ends by a failure, what its tries have left goes with it.
  void forget_solves() {
    if constexpr (requires { stepper_.forget_solves(); }) stepper_.forget_solves();
  }
  bool end(Outcome outcome) {
    if (outcome != Outcome::success && outcome != Outcome::stopped_by_observer && outcome != Outcome::stopped_by_event)
      forget_solves();
    ended_ = true;
    report_.outcome = outcome;
    return false;
  }
  static constexpr bool sees_error = [] {
    if constexpr (is_fixed) return false;
    else return Pace::sees_error;
  }();
  /// Where an interpolant is worst.
  static constexpr auto doubtful_places = [] {
    if constexpr (requires { Stepper::doubtful_at; }) return Stepper::doubtful_at;
    else return SchemeDefaults::doubtful_at;
  }();
  static constexpr bool interpolates = sees_error && requires { requires Stepper::interpolates; };
  static constexpr Looks looks = [] {
    if constexpr (requires { typename Stepper::SchemeType; })
      if (is_extrapolated<typename Stepper::SchemeType>) return Looks::extrapolated;
    return StepInside<Stepper, S>::is_possible ? Looks::may_look : Looks::not_copied;
  }();
  template <class Observer>
  static constexpr bool may_look_inside = [] {
    if constexpr (requires { requires Observer::looks_at_ends_alone; }) return false;
    else return EventLike<Observer> || observes_steps<Observer, S>;
  }();
  static constexpr bool looks_inside =
      looks == Looks::may_look && (may_look_inside<std::remove_reference_t<Observers>> || ...);
  struct Nothing {};
  static constexpr bool can_go_back = requires(Stepper & stepper) { stepper.restore(stepper.checkpoint()); };
  static constexpr bool keeps_past = (has_events || looks_inside) && can_go_back;
  static auto checkpoint_of() {
    if constexpr (keeps_past) return std::optional<decltype(std::declval<Stepper&>().checkpoint())>{};
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
  Outcome outcome_ = Outcome::success, bad_slope_ = Outcome::non_finite_force;
  bool begun_ = false, ended_ = false, first_ = true;
  Way way_ = Way::plain;                  // of the last attempt
  bool alone_ = false;                    // no observers: the state cannot be edited between steps
  bool slopes_are_finite_ = true;         // of the step just done, if they were computed
  Outcome looked_ = Outcome::success;     // of the steps to states asked for inside the step
  InterpolantTrust trust_, parts_trust_;  // in the interpolant of a step, and of its parts
  int looks_ = 0;                         // at states inside the step just done, where its interpolant is off
  LookInside look_;                       // into the step that dense_ tells of
  std::int64_t changes_ = 0;
  EditGuard<S, false, false> edits_;
  [[no_unique_address]] std::conditional_t<sees_error, StepDoubling<Stepper, S>, Nothing> doubling_;
  [[no_unique_address]] std::conditional_t<observed, Plain, Nothing> start_;
  [[no_unique_address]] decltype(checkpoint_of()) before_step_;
  [[no_unique_address]] std::conditional_t<borrowed, Plain, Nothing> gathered_;
  [[no_unique_address]] std::conditional_t<observed, DenseOutput<S>, Nothing> dense_;
  struct NoLook {};
  [[no_unique_address]] std::conditional_t<looks_inside, Plain, NoLook> end_, off_;
  [[no_unique_address]] std::conditional_t<looks_inside, std::optional<StepInside<Stepper, S>>, NoLook> inside_;
  struct NoParts {
    static void reset() {}
  };
  [[no_unique_address]] std::conditional_t<looks_inside && sees_error, std::optional<PartsInside<Stepper, S>>, NoParts>
      parts_;
};

/// No run: says why, and nothing else.
template <class Stepper, class S, class Control, class... Observers>
  requires(!MutableState<S&> || !ControlOf<Control, S> || !fits_state<Stepper, S>)
class Run<Stepper, S, Control, Observers...> {
  static_assert(StateRefusal<MutableState<S&>, S>::is_said);
  static constexpr bool has_control = !MutableState<S&> || ControlOf<Control, S>,
                        has_stepper = !MutableState<S&> || fits_state<Stepper, S>;
  static_assert(
      has_control,
      "phistep: say how dt is chosen: fixed(0.1) for steps of 0.1, tolerance{.rtol = 1e-6}, iteration_control{...} "
      "or smaller_of(...)");
  static_assert(has_stepper, "phistep: the stepper was made for a state of another type");

 public:
  Run(Stepper&, S&, typename SpanOf<S>::type, const Control&, Observers&&...) {}
  bool advance() { return false; }
  RunReport finish() { return {}; }
  [[nodiscard]] RunReport report() const { return {}; }
};

template <class Stepper, class S, class Control, class... Observers>
Run(Stepper&, S&&, typename SpanOf<std::remove_reference_t<S>>::type, const Control&, Observers&&...)
    -> Run<Stepper, std::remove_reference_t<S>, Control, Observers...>;

}  // namespace phistep::inline PHISTEP_ABI
