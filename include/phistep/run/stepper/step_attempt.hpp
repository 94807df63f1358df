/// @file
/// The step that a run is about to do: how long it is, where it starts, how it is tried, and the way back to its start.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/run/control/rounding_probe.hpp"
#include "phistep/run/control/run_clock.hpp"
#include "phistep/run/control/run_report.hpp"
#include "phistep/run/errors/step_filter.hpp"
#include "phistep/run/stepper/any_stepper.hpp"
#include "phistep/run/stepper/step_doubling.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @tparam Pace         of the run: it judges steps where it sees their error
/// @tparam keeps_start  the step can be undone, and interpolated
template <class Stepper, State S, class Pace, bool keeps_start>
class StepAttempt {
  static_assert(!Pace::varies || !facts_of<Stepper>.has_inner_steps,
                "phistep: seldom(k, term) takes steps of one length, fixed(dt): a step that changes would meet "
                "resonances, and nothing tells its error");

 public:
  using StepperType = Stepper;
  using StateType = S;
  using PaceType = Pace;
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  StepAttempt(Stepper& stepper, S& state, TimeSpan<Scalar> span, Pace pace)
      : stepper_{stepper}, state_{state}, pace_{std::move(pace)}, clock_{span}, from_{clock_} {}

  /// All that begins a run but force calls.
  [[nodiscard]] Outcome set_up() {
    if constexpr (chooses) scheme_ = stepper_.active();
    if constexpr (Pace::varies) {
      const Outcome begun = pace_.begin(plain(), error_law(stepper_));
      if constexpr (probes)
        if (pace_.keeps_sizes()) probed_from_ = plain();
      if constexpr (keeps_sizes)
        if (pace_.keeps_sizes()) kept_sizes(stepper_).go_on(plain(), pace_.sizes());
      return begun;
    } else {
      return pace_.begin(clock_.span());
    }
  }
  void end_run() {
    if constexpr (keeps_sizes)
      if (pace_.keeps_sizes()) kept_sizes(stepper_).keep(plain(), pace_.sizes());
  }
  [[nodiscard]] Outcome begin_run() {
    if constexpr (Pace::varies) {
      const auto [t0, t1] = clock_.span();
      if (!std::isfinite(t1 - t0)) return Outcome::invalid_step;
      if (t1 == t0) return Outcome::success;
      if (first_non_finite(Blocks<S>::all(plain()))) return Outcome::non_finite_state;
      if (const Outcome bad = set_up(); failed(bad)) return bad;
      Outcome told = Outcome::success;
      const Times<Scalar> inside{t0, t1 - t0, Origin{Origin::unknown, true, true}};
      const auto slope = [&](Scalar t, const Plain& y, Plain& out) {
        told = slope_of<S>(stepper_, inside(t), y, out);
        return !failed(told);
      };
      Outcome bad = pace_.start(clock_.span(), plain(), stepper_.order(), slope);
      if constexpr (chooses)
        if (!failed(bad) && stepper_.begin_run(state_, plain(), clock_, pace_)) {
          if (const Outcome other = set_up(); failed(other)) return other;
          bad = pace_.start(clock_.span(), plain(), stepper_.order(), slope);
        }
      return bad == Outcome::non_finite_force && failed(told) ? told : bad;
    } else {
      return set_up();
    }
  }
  [[nodiscard]] bool is_at_end() const { return pace_.is_at_end(clock_); }
  void accepted(const Landing<Scalar>& to, [[maybe_unused]] Limits& limits) {
    stands_at_jump_ = to.at_stop;
    if constexpr (Pace::varies) pace_.accepted(to, stepper_.last_solve(), limits);
    else pace_.accepted(to);
  }
  /// After a try that failed: success where the pace has a shorter one, else how the run ends.
  [[nodiscard]] Outcome retry(Outcome why, [[maybe_unused]] const Landing<Scalar>& to,
                              [[maybe_unused]] Limits& limits) {
    if constexpr (Pace::varies) return pace_.failed(why, to, stepper_.last_solve(), limits);
    else return why;
  }

  /// A step starts where the run stands.
  /// @param keeps_past  the stepper's history is kept, too
  /// @param is_first    of the run
  void begin([[maybe_unused]] bool keeps_past, bool is_first) {
    // Ψ known at a stop is that of the time before: the force may have jumped there, or have been switched.
    if (stands_at_jump_ && !is_first) {
      if constexpr (Pace::sees_error) pace_.forget_past();
      forget_what_is_known(stepper_);
    }
    choose_scheme();
    if constexpr (keeps_start) {
      from_ = clock_;
      copy_blocks<S>(start_, state_);
      if (keeps_past) past_.emplace(past_of(stepper_));
    }
  }
  /// Tries it. A step that is done is the state, and the clock has moved.
  /// @param may_probe  where it fails, a probe may measure what rounding makes of it
  [[nodiscard]] StepReport attempt(const Landing<Scalar>& to, Origin origin, [[maybe_unused]] bool may_probe = true) {
    way_ = Way::plain;
    origin.starts_at_jump = stands_at_jump_;
    origin.ends_at_jump = to.at_stop;
    origin_ = origin;
    StepReport done;
    struct EndProbe {
      StepAttempt* step = nullptr;
      ~EndProbe() {
        if constexpr (probes)
          if (step != nullptr) step->end_probe();
      }
    } probe;
    for (;;) {  // one call, so that the compiler makes one loop of it
      const bool is_moved = probes && std::exchange(has_probed_, false);
      const StepReport now = attempt_in_a_way(to, is_moved ? origin.with(Origin::unknown) : origin);
      if (probe.step != nullptr) break;  // never accepted
      done = now;
      if constexpr (probes)
        if (!done && may_probe && begins_probe(done.outcome(), to)) {
          probe.step = this;
          continue;
        }
      break;
    }
    if (done) clock_.move(to);
    return done;
  }
  /// State, clock and history are again those of the step's start.
  void undo() { put_back(*past_); }
  /// The same where there will be no other try: it allocates nothing, and what tries have left goes with the step.
  void undo_for_good() {
    put_back(std::move(*past_));
    forget_solves();
  }
  void forget_solves() {
    StepperInternals::at_work(stepper_, [](auto& one) { one.forget_solves(); });
  }

  [[nodiscard]] Stepper& stepper() const { return stepper_; }
  [[nodiscard]] S& state() const { return state_; }
  [[nodiscard]] Pace& pace() { return pace_; }
  [[nodiscard]] const Pace& pace() const { return pace_; }
  [[nodiscard]] RunClock<Scalar>& clock() { return clock_; }
  [[nodiscard]] const RunClock<Scalar>& clock() const { return clock_; }
  /// The state as one that owns its numbers: those of a view (Map) are copied.
  [[nodiscard]] const Plain& plain() { return gathered<S>(state_, gathered_); }
  [[nodiscard]] Scalar t0() const { return from_.t(); }        ///< [time] where the step started
  [[nodiscard]] const Plain& start() const { return start_; }  ///< the state there
  [[nodiscard]] const Past<Stepper>& past() const { return *past_; }
  [[nodiscard]] bool& stands_at_jump() { return stands_at_jump_; }
  /// The origin of the step done last, or of a part from its start.
  [[nodiscard]] Origin origin(bool whole) const {
    return {Origin::unknown, origin_.starts_at_jump, whole && origin_.ends_at_jump};
  }
  /// From where the run stands to a time inside the step.
  [[nodiscard]] Scalar length_to(Scalar t) const {
    if constexpr (Pace::varies) return clock_.length_to(t);
    else return pace_.length(clock_.t(), t);
  }
  /// Whether the trace holds the step's error and, if the stepper can give them, its slopes.
  [[nodiscard]] bool is_traced() const { return way_ == Way::traced; }
  /// The state half way, where the step was done as two halves; else null.
  [[nodiscard]] const Plain* middle() const {
    if constexpr (Pace::sees_error)
      if (way_ == Way::doubled) return &doubling_.middle();
    return nullptr;
  }

 private:
  /// How a step was tried: without an estimate of its error, by a scheme that estimates it, or in two halves.
  enum class Way { plain, traced, doubled };
  static constexpr bool probes = Pace::sees_error && !FieldState<S>;
  static constexpr bool keeps_sizes = probes && !std::is_void_v<decltype(kept_sizes(std::declval<Stepper&>()))>;
  static constexpr bool chooses = Pace::sees_error && ChoosesScheme<Stepper, S, Pace>;

  void put_back(auto&& past) {
    copy_blocks<S>(state_, start_);
    clock_ = from_;
    if constexpr (Pace::sees_error)
      if (std::exchange(way_, Way::plain) == Way::doubled) pace_.trace().step_back();
    require_past<Stepper>();
    if constexpr (can_go_back<Stepper>) go_back(stepper_, std::forward<decltype(past)>(past));
  }
  /// A stepper that chooses its scheme does so here, where no step is under way.
  void choose_scheme() {
    if constexpr (chooses) {
      if (const auto longest = stepper_.choose(state_, plain(), clock_, pace_))
        pace_.change(error_law(stepper_), *longest);
      else if (scheme_ != stepper_.active()) pace_.obey(error_law(stepper_));  // a run that resumes
      scheme_ = stepper_.active();
    }
  }
  /// The last try has failed: by more than rounding? A probe, or a few slopes, tell.
  [[nodiscard, gnu::noinline]] bool begins_probe(Outcome why, const Landing<Scalar>& to) requires probes {
    if (!pace_.doubts(why, to)) {
      if (why != Outcome::error_too_large && pace_.knows_rates()) look_at_rates(to);
      return false;
    }
    // Where something begins that had no size, corrections have no weight, and are off by more than rounding.
    if (pace_.trace().rate != nullptr && stepper_.last_solve().iterations > 0) return false;
    copy_blocks<S>(probed_from_, plain());
    pace_.begin_probe(probed_from_, stepper_.last_solve().iterations > 0);
    copy_blocks<S>(state_, pace_.trace().predicted);
    return has_probed_ = true;
  }
  void end_probe() requires probes {
    copy_blocks<S>(state_, probed_from_);
    has_probed_ = true;
    pace_.end_probe();
  }
  /// A solve has failed. No correction gets below what roundings of y make of y' during the step.
  [[gnu::noinline]] void look_at_rates(const Landing<Scalar>& to) requires probes {
    const Times<Scalar> inside{clock_.t(), to.dt, Origin{Origin::unknown, stands_at_jump_, to.at_stop}};
    auto& trace = pace_.trace();
    for (const std::uint64_t number : {0U, 1U, 2U, 3U}) {
      copy_blocks<S>(trace.predicted, plain());
      if (number > 0) move_numbers(trace.predicted, number, std::numeric_limits<Scalar>::epsilon());
      Plain& rate = number == 0 ? trace.error : trace.end;  // scratch: the step has failed
      if (failed(slope_of<S>(stepper_, inside(clock_.t()), trace.predicted, rate))) return;
      if (number > 0) pace_.learn_rates(to.dt);
    }
  }
  [[nodiscard]] StepReport attempt_in_a_way(const Landing<Scalar>& to, Origin origin) {
    if constexpr (Pace::sees_error) {
      auto& trace = pace_.trace();
      const Scalar t = clock_.t();
      const double length = std::abs(static_cast<double>(to.dt));
      pace_.prepare(plain(), length);
      trace.wants_dense = keeps_start;
      trace.asks_end = to.at_stop;
      // A step of a few ticks of the clock, where far longer ones are within the tolerance, tells of rounding alone.
      const bool is_tick =
          to.lands && length <= static_cast<double>(clock_.rounding(t)) && 100 * length <= pace_.propose();
      const Judge<Plain> accept{pace_};
      if constexpr (facts_of<Stepper>.traces)
        if (!is_tick && stepper_.estimates(trace)) {
          way_ = Way::traced;
          return stepper_.attempt(state_, t, to.dt, origin, trace, accept);
        }
      // Neighbouring floating-point times have no midpoint: the step cannot be halved.
      const Scalar middle = t + to.dt / 2;
      const bool halves = !is_tick && middle != t && middle != t + to.dt;
      const StepReport done = doubling_.attempt(stepper_, state_, t, to.dt, origin, trace, accept, halves);
      if (done && halves) way_ = Way::doubled;
      return done;
    } else {
      return do_step(stepper_, state_, clock_.t(), to.dt, origin);
    }
  }

  Stepper& stepper_;
  S& state_;
  Pace pace_;
  RunClock<Scalar> clock_, from_;
  Way way_ = Way::plain;             // of the last attempt
  bool has_probed_ = false;          // the stepper has stepped from another state since
  bool stands_at_jump_ = true;       // the force may jump where the run stands
  Origin origin_ = Origin::unknown;  // of the step tried last
  [[no_unique_address]] Only<probes, Plain, 2> probed_from_;
  int scheme_ = -1;  // that the pace obeys, of a stepper that chooses
  [[no_unique_address]] Only<keeps_start, Plain> start_;
  [[no_unique_address]] Only<keeps_start, std::optional<Past<Stepper>>> past_;
  [[no_unique_address]] Only<Pace::sees_error, StepDoubling<Stepper, S>> doubling_;
  [[no_unique_address]] Only<!std::is_same_v<S, Plain>, Plain, 1> gathered_;
};

}}  // namespace phistep::PHISTEP_ABI
