/// @file
/// States inside the step that a run has just done. They come from the interpolant where that is right to half the
/// tolerance, which steps that end inside tell; else from a step really done.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/run/control/run_report.hpp"
#include "phistep/run/inside/dense_output.hpp"
#include "phistep/run/stepper/any_stepper.hpp"
#include "phistep/run/stepper/step_doubling.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Whether the interpolant needs no check: by its scheme's word; or Hermite's, whose error of Δt⁴ is less than steps of order 1
/// and 2 leave, unless a stiff component makes large slopes of small errors.
/// @tparam sees_error  the run's steps are traced
template <bool sees_error, class Stepper>
[[nodiscard]] bool is_sure_inside(const Stepper& stepper) {
  return StepperInternals::chosen(stepper, []<class One>([[maybe_unused]] const One& one) {
    if constexpr (sees_error && facts_of<One>.is_sure_inside) return true;
    else if constexpr (facts_of<One>.solves_nothing) return one.order() <= 2;
    else return false;
  });
}

/// How long a check of the interpolant holds. A check compares it with steps that end inside the step, which is twice the work of
/// the step itself: where its result was clear, it holds for 1, 2, then 4 steps, as long as Δt stays about the same. Where it was
/// right it holds longer, as long as the step's bend tells so, which costs nothing: how far the interpolant is off Hermite's
/// cubic, which goes as Δt⁴; the errors of explicit pairs go as its square, or cube.
class InterpolantTrust {
 public:
  void step() {
    is_fresh_ = left_ > 0;
    left_ = std::max(left_ - 1, 0);
    age_ = std::min(age_ + 1, oldest);
  }
  /// What the last check says of a step of this length [time] and bend; empty: it has to be checked.
  [[nodiscard]] std::optional<double> known(double dt, double bend) const {
    if (is_fresh_ && dt_ / 2 < dt && dt < 1.05 * dt_) return error_;
    if (age_ == oldest || !(bend > 0 && bend_ > 0) || dt > 1.5 * dt_) return {};
    const double grown = std::max(1.0, bend / bend_), squared = grown * grown, now = error_ * squared * squared;
    if (now <= 0.8 * for_states) return now;
    return {};
  }
  /// A check has found the interpolant off by `error`, in units of the tolerance. @return that, at most `off`
  /// @param bend  likewise; 0: not known
  double check(double dt, double bend, double error) {
    bend_ = bend;
    age_ = 0;
    error_ = error <= off ? error : off;  // NaN, too
    // Clear is ten times less or more than right. The 1.05 above makes 1.05¹² = 1.8 of an error that goes as Δt¹².
    const bool is_clear = error <= 0.05 || !(error <= 5);
    steps_ = is_clear ? std::clamp(2 * steps_, 1, 4) : 0;
    left_ = steps_;
    dt_ = dt;
    is_fresh_ = true;
    return error_;
  }
  /// In units of the tolerance: so good is a state inside a step; so bad may the way to an event be, which a step finds in the end.
  static constexpr double for_states = 0.5, for_events = 20, off = 2 * for_events;
  void forget() { *this = {}; }

  void archive(auto& ar) {
    ar("dt", dt_, "steps", steps_, "left", left_, "error", error_, "is_fresh", is_fresh_, "bend", bend_, "age", age_);
    ar.check(dt_ >= 0 && 0 <= left_ && left_ <= steps_ && steps_ <= 4 && error_ >= 0 && 0 <= age_ && age_ <= oldest);
  }

 private:
  static constexpr int oldest = 32;  // steps that a check may serve

  double dt_ = 0, bend_ = 0;  // of the step that was checked [time]
  int age_ = oldest;          // steps since
  int steps_ = 0, left_ = 0;
  double error_ = 0;
  bool is_fresh_ = false;
};

/// @tparam Attempt     a StepAttempt
/// @tparam does_steps  steps may be done inside; else states come from Hermite's interpolant
template <class Attempt, bool does_steps>
class LookInside {
 public:
  using Stepper = typename Attempt::StepperType;
  using S = typename Attempt::StateType;
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  /// @param report  the run's: it counts what states inside cost, and says why one failed
  LookInside(Attempt& step, InterpolantTrust& trust, RunReport& report) : step_{step}, trust_{trust}, report_{report} {}

  /// The step has been done, and no state inside it asked for.
  void begin(Scalar dt) {
    slopes_ = looked_ = Outcome::success;
    trust_.step();
    begin_again(dt);
  }
  /// The step has been done again, to an earlier end: forgets what was made for the longer one.
  void begin_again(Scalar dt) {
    if constexpr (does_steps) work_.has_begun = false;
    dt_ = dt;
    is_checked_ = false;
    error_.reset();
    dense_.begin(step_.t0(), dt, step_.clock().t(), step_.start(), step_.plain(), *this);
    is_own_ = facts_of<Stepper>.interpolates && step_.is_traced();
    knows_inside_.reset();
  }
  /// The state at t; valid until the next call.
  [[nodiscard]] const Plain& at(Scalar t) {
    if constexpr (does_steps)
      if (is_checked_ && dense_.is_inside(t)) {
        if (!error_) error_ = measure();
        if (*error_ > InterpolantTrust::for_states) {
          static_cast<void>(go_to(t, work_.found));
          return work_.found;
        }
      }
    return interpolated(t);
  }
  /// From here on states inside are checked, where there is a doubt.
  void check() {
    if constexpr (does_steps) is_checked_ = !is_sure_inside<sees_error>(step_.stepper());
  }
  /// The same; true where those seen so far were far off.
  [[nodiscard]] bool was_off() {
    if constexpr (does_steps && sees_error) {
      check();
      if (is_checked_) error_ = measure();
      return is_checked_ && *error_ > InterpolantTrust::for_events;
    } else {
      return false;
    }
  }
  /// Whether all states inside were found: a failure, of a slope or of the step to a state, ends the run.
  [[nodiscard]] Outcome outcome() const { return failed(looked_) ? looked_ : slopes_; }

  /// Slopes at both ends: the scheme's own where it has left them, else by two force calls.
  void operator()(Plain& at_start, Plain& at_end) {
    if constexpr (sees_error)
      if (step_.is_traced() && knows_slopes()) {
        const auto& trace = step_.pace().trace();
        copy_blocks<S>(at_start, trace.has_slopes ? trace.start : trace.before);
        copy_blocks<S>(at_end, trace.has_slopes ? trace.end : trace.start);
        return;
      }
    const Times<Scalar> inside{step_.t0(), dt_, step_.origin(true)};
    const Outcome first = slope_of<S>(step_.stepper(), inside(step_.t0()), step_.start(), at_start);
    const Outcome last = slope_of<S>(step_.stepper(), inside(step_.clock().t()), step_.plain(), at_end);
    slopes_ = failed(first) ? first : last;
    complete_slopes<S>(step_.stepper(), step_.start(), step_.plain(), dt_, at_start, at_end);
  }

 private:
  static constexpr bool sees_error = Attempt::PaceType::sees_error;

  /// Whether what the scheme knows of the inside, if it knows it, is there: it may call the force to learn it.
  [[nodiscard]] bool is_known_inside() {
    if (is_own_ && !knows_inside_)
      knows_inside_ = StepperInternals::chosen(step_.stepper(), [this]<class One>([[maybe_unused]] One& one) {
        if constexpr (facts_of<One>.interpolates) return one.know_inside(dt_, step_.start());
        else return false;
      });
    return knows_inside_.value_or(true);
  }
  /// The state at t, by the scheme's interpolant or Hermite's.
  [[nodiscard]] const Plain& interpolated(Scalar t) {
    if constexpr (facts_of<Stepper>.interpolates)
      if (is_own_ && dense_.is_inside(t) && is_known_inside()) {
        copy_blocks<S>(inside_, step_.start());
        StepperInternals::chosen(step_.stepper(), [&]<class One>([[maybe_unused]] One& one) {
          if constexpr (facts_of<One>.interpolates)
            one.interpolate((t - step_.t0()) / dt_, dt_, step_.start(), step_.plain(), inside_);
        });
        return inside_;
      }
    return dense_.at(t);
  }

  /// Whether the trace has this step's slopes: as `start` and `end` or, after advance(), as `before` and `start`.
  [[nodiscard]] bool knows_slopes() const {
    const auto& trace = step_.pace().trace();
    return trace.has_slopes || trace.dt_before != 0;
  }
  [[nodiscard]] bool is_explicit() const {
    return StepperInternals::chosen(step_.stepper(),
                                    []<class One>(One&) -> bool { return facts_of<One>.solves_nothing; });
  }
  /// How far the interpolant is off Hermite's in the middle, in units of the tolerance.
  [[nodiscard]] double measure_bend() {
    const Scalar t = step_.t0() + dt_ / 2;
    copy_blocks<S>(work_.found, interpolated(t));
    assign<S>(work_.found, in<S>(work_.found) - in<S>(dense_.at(t)));
    return step_.pace().size(work_.found, step_.start(), step_.plain());
  }
  /// The interpolant's error in units of the tolerance, at two places where steps are done to learn it: at one alone it may pass
  /// zero. At a fixed Δt, which has no tolerance, it is far off.
  [[nodiscard]] double measure() {
    if constexpr (sees_error) {
      if (!is_known_inside()) return InterpolantTrust::off;
      const double length = std::abs(static_cast<double>(dt_));
      const double bend = step_.is_traced() && knows_slopes() && is_explicit() ? measure_bend() : 0;
      if (const std::optional<double> known = trust_.known(length, bend)) return *known;
      double worst = 0;
      for (const double x : facts_of<Stepper>.doubtful_at.value) {
        if (!(worst <= InterpolantTrust::for_events)) break;
        const Scalar t = step_.t0() + static_cast<Scalar>(x) * dt_;
        if (!go_to(t, work_.found)) return 0;  // a step that fails ends the run
        assign<S>(work_.found, in<S>(interpolated(t)) - in<S>(work_.found));
        const double error = step_.pace().size(work_.found, step_.start(), step_.plain());
        worst = error <= worst ? worst : error;  // NaN, too
      }
      return trust_.check(length, bend, worst);
    } else {
      return InterpolantTrust::off;
    }
  }
  /// out = y(t) by a step from the start. False where it fails, and the run ends with that.
  [[nodiscard]] bool go_to(Scalar t, Plain& out) {
    const Scalar from = step_.t0(), dt = t - from;
    if (std::abs(dt) <= step_.clock().rounding(from)) {  // no step, and nothing to tell its ends apart
      copy_blocks<S>(out, interpolated(from + dt));
      return true;
    }
    if (!work_.has_begun) {
      if constexpr (std::is_copy_assignable_v<Stepper>) work_.spare = step_.stepper();
      else work_.spare.emplace(step_.stepper());
      work_.has_begun = true;
    }
    copy_blocks<S>(work_.end, step_.state());
    const AtExit put_back_and_book{[this, before = work_.spare->statistics()] {
      copy_blocks<S>(step_.state(), work_.end);
      Statistics cost = work_.spare->statistics() - before;
      cost.steps = cost.failed_steps = cost.rejections = 0;
      report_.statistics = report_.statistics + cost;
    }};
    copy_blocks<S>(step_.state(), step_.start());
    const StepReport done = step_by(from, dt);
    copy_blocks<S>(out, step_.state());
    if (!done && !failed(looked_)) {
      looked_ = done.outcome();
      report_.failure = done.failure();
    }
    return static_cast<bool>(done);
  }

  /// state = y(t + dt) from y(t), by one step at a fixed Δt, or by as many as the error asks for.
  [[nodiscard]] StepReport step_by(Scalar t, Scalar dt) {
    const Origin origin = step_.origin(false);
    go_back(*work_.spare, step_.past());
    if constexpr (sees_error) {
      work_.trace = step_.pace().trace();
      work_.trace.wants_dense = false;
      work_.left = most_tries;
      return part(t, dt, origin);
    } else {
      return do_step(*work_.spare, step_.state(), t, dt, origin);
    }
  }
  /// Its error is tested as that of any step, and where it fails it is done as two halves.
  StepReport part(Scalar t, Scalar dt, const Origin& origin) {
    work_.trace.forget();
    const StepReport done = attempt(t, dt, origin);
    const bool may_halve = done.outcome() == Outcome::error_too_large || may_be_cured(done.outcome());
    const Scalar half = dt / 2;
    // Where shorter and shorter steps fail, why they do is the story.
    if (done || !may_halve || --work_.left == 0 || t + half == t) return done;
    const StepReport first = part(t, half, origin.first_part());
    return first ? part(t + half, half, origin.last_part()) : first;
  }
  StepReport attempt(Scalar t, Scalar dt, const Origin& origin) {
    const Judge<Plain> allows{std::as_const(step_.pace())};
    if constexpr (facts_of<Stepper>.traces)
      if (work_.spare->estimates(work_.trace))
        return work_.spare->attempt(step_.state(), t, dt, origin, work_.trace, allows);
    return work_.doubling.attempt(*work_.spare, step_.state(), t, dt, origin, work_.trace, allows);
  }

  static constexpr int most_tries = 2000;

  /// For states inside the step by shorter ones from the same start, by a copy of the stepper, so that the run goes on without a change.
  /// The copy is made once, and from then on assigned to: that allocates nothing where sizes stay (and the force can be assigned,
  /// step/equation/right_hand_side.hpp).
  struct Work {
    std::optional<Stepper> spare;
    bool has_begun = false;  // it is as the step left it, but for steps inside
    Trace<Plain> trace;
    StepDoubling<Stepper, S> doubling;
    int left = 0;  // tries that may still fail
    Plain end;     // the step's end, while the state is one inside the step
    Plain found;   // the state last asked for
  };

  Attempt& step_;
  InterpolantTrust& trust_;
  RunReport& report_;
  Scalar dt_{};
  DenseOutput<S> dense_;
  bool is_own_ = false;               // the scheme may know the inside
  std::optional<bool> knows_inside_;  // whether it does; empty: it has not been asked
  [[no_unique_address]] Only<facts_of<Stepper>.interpolates.value, Plain, 3> inside_;
  bool is_checked_ = false;            // states inside are more than interpolated
  std::optional<double> error_;        // of this step's interpolant, in tolerances
  Outcome slopes_ = Outcome::success;  // of the step just done, if they were computed
  Outcome looked_ = Outcome::success;  // of steps to states inside
  [[no_unique_address]] Only<does_steps, Work> work_;
};

}}  // namespace phistep::PHISTEP_ABI
