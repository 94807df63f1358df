/// @file
/// How long the steps of a run are: what a Run asks between its steps. A pace that varies
///
///     Outcome begin(y, law)                    reads the options
///     Outcome start(span, y, order, slope)     chooses a first length; slope(t, y, out) costs a force call
///     double propose()                         |Δt| it would take next
///     bool is_at_end(clock), may_try()         whether the run is done; whether there may be another try
///     Landing plan(clock, stop)                where the next step is to land, at a stop or before
///     prepare(y, dt), judge(…)                 before and inside an attempt, where it wants to see the error
///     accepted(to, record, limits)            the step has become the state
///     Outcome failed(outcome, to, …)           success: try again with what plan() says now
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/control/error_law.hpp"
#include "phistep/run/control/iteration_control.hpp"
#include "phistep/run/control/limits.hpp"
#include "phistep/run/control/run_clock.hpp"
#include "phistep/run/control/variable_step.hpp"
#include "phistep/run/errors/error_norm.hpp"
#include "phistep/run/errors/step_filter.hpp"
#include "phistep/run/errors/tolerance.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// `tolerance{…}`, alone or with an iteration_control.
template <State S>
class ErrorPace : public VariableStep<ScalarOf<S>> {
  using Length = VariableStep<ScalarOf<S>>;

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  static constexpr bool sees_error = true;

  explicit ErrorPace(tolerance wanted) : wanted_{std::move(wanted)} {}
  explicit ErrorPace(const SmallerOf& both) : wanted_{both.error}, iterations_{both.iterations}, counts_{true} {}

  [[nodiscard]] Outcome begin(const Plain& y, const ErrorLaw& law) {
    constexpr double round_off = static_cast<double>(std::numeric_limits<Scalar>::epsilon());
    if (!norm_.begin(wanted_, y))
      return Length::refuse(wanted_.rtol > 0 && wanted_.rtol < 1 ? Refused{"atol, or the norm"}
                                                                 : Refused{"rtol", wanted_.rtol});
    size_ = {};
    obey(law);
    // An error of a few roundings can't be told from rounding; where stages are combined with weights of up to a hundred,
    // as high orders do, one of some dozens.
    const double least = (law.error_order <= law.order ? 64 : 8) * round_off;
    if (wanted_.rtol * std::min(allowed_, 1.0) < least)
      return Length::refuse({"rtol, which is below rounding", wanted_.rtol,
                             std::pow(least, std::min(1.0, law.order / static_cast<double>(law.error_order)))});
    if (!(wanted_.first_step >= 0)) return Length::refuse({"first_step", wanted_.first_step});
    if (const char* bad = counts_ ? what_cannot_work(iterations_) : nullptr) return Length::refuse({bad});
    trace_.resize(y);
    trace_.rtol = wanted_.rtol;
    trace_.has_met_bound = false;
    doubt_ = {};
    has_end_ = false;
    if (keeps_sizes()) end_ = error_before_ = usual_ = y;
    return Length::bound(std::max(wanted_.min_step, counts_ ? iterations_.min_step : wanted_.min_step),
                         std::min(wanted_.max_step, counts_ ? iterations_.max_step : wanted_.max_step),
                         std::min(wanted_.max_steps, counts_ ? iterations_.max_steps : wanted_.max_steps));
  }
  [[nodiscard]] Outcome start(TimeSpan<Scalar> span, const Plain& y, int order, auto&& slope) {
    double first = wanted_.first_step;
    if (first == 0) {
      norm_.weigh(y, trace_.weight);
      first = first_step(slope, y, norm_, trace_.weight, span.t0, span.t1 - span.t0, order, allowed_);
      if (first == 0) return Outcome::non_finite_force;
      // Far from t = 0 the clock may be coarser than what is known of y: a step that it can't show is none.
      const Scalar tick = 16 * std::numeric_limits<Scalar>::epsilon() * std::abs(span.t0);
      first = std::max(first, static_cast<double>(std::min(tick, std::abs(span.t1 - span.t0))));
    }
    if (counts_ && iterations_.first_step > 0) first = std::min(first, iterations_.first_step);
    Length::set(first);
    return Outcome::success;
  }

  /// No atol is given.
  [[nodiscard]] bool keeps_sizes() const { return knows_rounding && norm_.is_automatic(); }
  /// A run that begins may go on from one before.
  void go_on(KeptSizes<Plain>& kept, const Plain& y) {
    if (norm_.is_automatic()) kept.go_on(y, norm_.automatic());
  }
  void keep(KeptSizes<Plain>& kept, const Plain& y) {
    if (norm_.is_automatic()) kept.keep(y, norm_.automatic());
  }

  [[nodiscard]] Trace<Plain>& trace() { return trace_; }
  void prepare(const Plain& y, double dt) {
    error_ = {};
    if (norm_.is_automatic()) norm_.automatic().begin_try(dt);
    trace_.proposed = 0;
    // Without a scale for each component, a solve's own error can't be weighed: then to rounding.
    if (!reads_weights_) norm_.remember(y);
    else trace_.newton_target = norm_.weigh(y, trace_.weight) ? newton_share * allowed_ / norm_.spread(y) : 0;
    trace_.usual = nullptr;
    if constexpr (knows_rounding)
      if (reads_weights_ && norm_.is_automatic()) {
        norm_.automatic().tell_usual(usual_);
        trace_.usual = &usual_;
      }
    trace_.has_unsized = knows_rounding && norm_.is_automatic() && !norm_.automatic().all_sized();
  }
  /// Whether the step's error is allowed.
  [[nodiscard, gnu::always_inline]] inline bool judge(const Plain& y, const Plain& next, const Trace<Plain>& told) {
    error_ = measure(told.error, y, next);
    if (knows_rounding && doubt_.is_probing) return false;
    error_.square *= told.error_scale_square;
    if (looks_for_jumps_ && !trace_.smoothness.holds(error_.square, static_cast<double>(told.dt), error_order_))
      error_.square *= missed_square;
    // A scheme that proposes Δt has judged.
    const bool is_allowed = trace_.proposed != 0 || error_.square <= allowed_ * allowed_;
    if (!is_allowed || !knows_rounding || !norm_.is_automatic()) return is_allowed;
    return !doubt_.is_due(error_.square >= 0.01 * allowed_ * allowed_);
  }
  /// Whether what failed the last try may be rounding: then it is to be tried again from a state a rounding away.
  [[nodiscard]] bool doubts(Outcome why, const Landing<Scalar>& to) {
    return knows_rounding && norm_.is_automatic() && has_doubts(why, to);
  }
  [[nodiscard, gnu::noinline]] bool has_doubts(Outcome why, const Landing<Scalar>& to) {
    if (why == Outcome::error_too_large) return doubt_.has_failed(std::abs(static_cast<double>(to.dt)), error_.size());
    doubt_.has_stalled = true;
    ++doubt_.tries;
    if constexpr (knows_rounding) norm_.automatic().unbear();
    return false;
  }
  /// What the next try makes of the end is rounding. @param iterates  steps are solved by iteration   @return the number of the probe
  [[nodiscard, gnu::noinline]] std::uint64_t begin_probe(bool iterates) {
    doubt_.iterates = iterates;
    doubt_.error = error_, doubt_.proposed = trace_.proposed;
    copy_blocks<Plain>(error_before_, trace_.error);
    doubt_.is_probing = true;
    doubt_.has_learned = false;
    return ++doubt_.probes;
  }
  /// It has been tried, whatever came of it.
  void end_probe() {
    doubt_.end_probe();
    error_ = doubt_.error, trace_.proposed = doubt_.proposed;
  }
  /// ‖e‖ that a step may have, in units of the tolerance
  [[nodiscard]] double allowed() const { return allowed_; }
  /// ‖e‖ in units of the tolerance, where e is what a state between y and next is off.
  [[nodiscard]] double size(const Plain& y, const Plain& next, const Plain& e) const {
    return norm_(e, y, next).size();
  }
  /// That of the try in hand, which teaches sizes: a probe that begins with a check of its start isn't that check.
  [[nodiscard]] double size_of_error(const Plain& y, const Plain& next) {
    return measure(trace_.error, y, next).size();
  }
  /// Whether the error of a step that is not the one in hand is allowed.
  [[nodiscard]] bool allows(const Plain& y, const Plain& next, const Trace<Plain>& told) const {
    return told.proposed != 0 || std::sqrt(told.error_scale_square) * size(y, next, told.error) <=
                                     allowed_;  // a scheme that proposes Δt has judged
  }
  [[gnu::always_inline]] inline void accepted(const Landing<Scalar>& to, const SolveRecord& record, Limits& limits) {
    const double dt = std::abs(static_cast<double>(to.dt));
    const double proposed = std::exchange(trace_.proposed, 0);
    trace_.advance();
    if (norm_.is_automatic()) {
      if constexpr (knows_rounding) tell(limits);
      norm_.automatic().accepted();
      doubt_.end_step();
    }
    const bool was_capped = Length::is_capped();
    double by = proposed > 0 ? proposed / dt : size_.accepted_square(error_.square * per_allowed_ * per_allowed_);
    bool by_iterations = false;
    if (counts_) {
      const double lambda = iteration_factor(record, iterations_);
      by_iterations = lambda < by;
      by = std::min(by, lambda);
    }
    if (to.clipped) {
      size_.forget();
      Length::set(std::max(Length::propose(), by * dt));
      // After a step that short, slopes by (y⁺ − b)/φΔt are rounding for the next.
      if (100 * dt < Length::propose()) trace_.forget();
      return limits.count(LimitedBy::stop);
    }
    Length::set(by * dt);
    if (was_capped) limits.count(LimitedBy::max_step);
    else if (by_iterations) limits.count(LimitedBy::iterations);
    else limits.count(LimitedBy::error, error_.worst);
  }
  [[nodiscard]] Outcome failed(Outcome why, const Landing<Scalar>& to, const SolveRecord&, Limits& limits) {
    const double dt = std::abs(static_cast<double>(to.dt)), proposed = std::exchange(trace_.proposed, 0);
    if (why != Outcome::error_too_large && !may_be_cured(why)) return why;
    if (std::exchange(doubt_.has_learned, false)) return Length::shorten(why, dt, 0.9);
    if (proposed > 0 && proposed < dt) return Length::shorten(why, dt, proposed / dt);
    if (why == Outcome::error_too_large) return Length::shorten(why, dt, size_.rejected(error_.size() / allowed_));
    const bool is_finite = why != Outcome::non_finite_force && why != Outcome::non_finite_state;
    trace_.has_met_bound = trace_.has_met_bound || !is_finite;
    limits.count(is_finite ? LimitedBy::iterations : LimitedBy::not_finite);
    size_.forget();
    return Length::shorten(why, dt, 0.25);
  }
  /// The steps to come are another scheme's, which knows nothing of those before. @param longest  [time] of the first
  void change(const ErrorLaw& law, double longest) {
    obey(law);
    forget_past();
    Length::set(std::min(Length::propose(), longest));
  }
  /// As a run that resumes finds it, with a stepper that had changed its scheme.
  void obey(const ErrorLaw& law) {
    // Estimates that go as the error at the end does, Δt^p, are held to the tolerance as they are.
    reads_weights_ = law.reads_weights;
    looks_for_jumps_ = law.looks_for_jumps;
    error_order_ = law.error_order;
    allowed_ = law.error_order == law.order
                   ? 1
                   : std::pow(wanted_.rtol, (law.error_order - law.order) / static_cast<double>(law.order));
    per_allowed_ = 1 / allowed_;
    size_.obey(wanted_.filter == StepFilter::automatic ? law.filter : wanted_.filter, law.error_order, law.dead_band);
  }
  /// weight = 1/(atol + rtol |y|), 0 where both are 0. @return rtol
  double weigh(const Plain& y, Plain& weight) {
    norm_.weigh(y, weight);
    return wanted_.rtol;
  }
  /// The next step has nothing to do with those before, but for its length.
  void forget_past() {
    size_.forget();
    trace_.forget();
  }
  /// The state isn't what the last step left. False where it outgrew the tolerances given.
  [[nodiscard]] bool edited(const Plain& y) {
    forget_past();
    if (same_shape<Plain>(trace_.weight, y)) {
      if constexpr (knows_rounding)
        if (norm_.is_automatic() && has_end_) norm_.automatic().edited(end_, y);
      return true;
    }
    trace_.resize(y);
    if (keeps_sizes()) end_ = error_before_ = usual_ = y;
    if (norm_.fits(y)) return true;
    static_cast<void>(Length::refuse({"atol, which is for a state of another size"}));
    return false;
  }

  void archive(auto& ar) {
    ar("norm", norm_, "filter", size_, "step", static_cast<Length&>(*this), "trace", trace_, "doubt", doubt_, "has_end",
       has_end_);
    if (has_end_) ar.in_place("end", end_);
  }

 private:
  /// Whether an error is rounding, which no step does better. A probe tells: the same step from a state that is a rounding away.
  /// There is one where errors rule Δt or a solve has stalled, after more and more steps while probes change nothing.
  struct Doubt {
    static constexpr int soon = 8, seldom = 1024;
    bool is_probing = false, is_wanted = false, has_learned = false, has_stalled = false;
    std::uint64_t probes = 0;    ///< that have been
    bool iterates = false;       ///< steps are solved by iteration
    Measured error;              ///< of the try before a probe, and …
    double proposed = 0;         ///< [time] … what it proposed
    double dt = 0, size = 0;     ///< [time] of the last try of this step; its ‖e‖
    int tries = 0, wait = soon;  ///< since the last probe; until the next

    void archive(auto& ar) {
      ar("stalled", has_stalled, "tries", tries, "wait", wait, "probes", probes);
      ar.check(tries >= 0 && 2 <= wait && wait <= seldom);
    }
    /// Whether a step within the tolerance is given up for a probe.
    [[nodiscard]] bool is_due(bool is_ruled_by_error) {
      return is_wanted = (is_ruled_by_error && tries >= 4 * wait) || (has_stalled && 4 * tries >= wait);
    }
    /// A try has failed. Whether a probe is due.
    [[nodiscard]] bool has_failed(double now, double now_size) {
      const bool falls = !(dt > 0) || now > 0.7 * dt || now_size * dt <= 0.5 * size * now;
      dt = now, size = now_size;
      ++tries;
      return is_wanted || tries >= (falls ? wait : std::min(wait, soon));
    }
    void end_probe() {
      is_probing = is_wanted = has_stalled = false;
      tries = 0;
      wait = has_learned ? 2 : std::min(2 * wait, seldom);
    }
    void end_step() {
      ++tries;
      dt = 0;
    }
  };
  static constexpr bool knows_rounding = !FieldState<Plain>;

  /// ‖e‖ of the try in hand
  [[nodiscard, gnu::always_inline]] inline Measured measure(const Plain& error, const Plain& y, const Plain& next) {
    if constexpr (knows_rounding)
      if (norm_.is_automatic()) return measure_by_sizes(error, y, next);
    return norm_(error, y, next);
  }
  [[nodiscard, gnu::noinline]] Measured measure_by_sizes(const Plain& error, const Plain& y, const Plain& next) {
    const Measured found = norm_(error, y, next);
    if (doubt_.is_probing || !(found.square <= allowed_ * allowed_ && norm_.automatic().all_sized()))
      return learn_sizes(found, error, y, next);
    copy_blocks<Plain>(end_, next);
    has_end_ = true;
    return found;
  }
  [[gnu::noinline]] void tell(Limits& limits) const {
    const auto component = [this](Index i) {
      Component found;
      for_each_block(
          [&](auto k, const auto& block) {
            if (found.block < 0 && i < block.size()) found = {static_cast<std::int64_t>(k()), i};
            i -= block.size();
          },
          Blocks<Plain>::all(trace_.weight));
      return found;
    };
    limits.has_own_scales = true;
    if (const Index i = norm_.automatic().below(); i >= 0) limits.below.name(component(i));
    if (const Index i = norm_.automatic().leapt(); i >= 0) limits.leapt.name(component(i));
  }
  /// The same after what a try that isn't good enough has to teach.
  [[nodiscard, gnu::noinline]] Measured learn_sizes(Measured found, const Plain& error, const Plain& y,
                                                    const Plain& next) {
    auto& atol = norm_.automatic();
    if (doubt_.is_probing) {
      // Less does no harm, and may be what an iteration has left. More is rounding, where the error isn't far more, of what an
      // iteration has solved is far less, or isn't the same.
      const double n = static_cast<double>(count_of(Blocks<Plain>::all(y)));
      const auto least = static_cast<Scalar>(0.03 * allowed_ * std::sqrt(n));
      for_each_number(
          [&](std::size_t at, Scalar e, Scalar e_before, Scalar from, Scalar now, Scalar before) {
            const auto i = static_cast<Index>(at);
            const Scalar moved = std::abs(now - before), size = std::max(std::abs(from), std::abs(now));
            const bool is_rounding = (doubt_.iterates ? Scalar{8} : Scalar(1e-3L)) * std::abs(e) <= moved ||
                                     4 * std::abs(e - e_before) >= std::abs(e_before);
            if (!std::isfinite(moved) || !is_rounding || moved <= least * norm_.scale(0, i, size)) return;
            atol.learn_noise(i, static_cast<Scalar>(64 / allowed_) * moved);
            doubt_.has_learned = true;
          },
          Blocks<Plain>::all(error), Blocks<Plain>::all(error_before_), Blocks<Plain>::all(y), Blocks<Plain>::all(next),
          Blocks<Plain>::all(end_));
      return {std::numeric_limits<double>::infinity(), {}};
    }
    copy_blocks<Plain>(end_, next);
    has_end_ = true;
    if (atol.all_sized()) return found;
    // Where the others are right, those that had no size have one now.
    double others = 0;
    std::int64_t n = 0;
    const auto each = [&](auto&& f) {
      for_each_number(
          [&f](std::size_t i, Scalar e, Scalar from, Scalar to) {
            f(static_cast<Index>(i), std::abs(e), std::max(std::abs(from), std::abs(to)));
          },
          Blocks<Plain>::all(error), Blocks<Plain>::all(y), Blocks<Plain>::all(next));
    };
    each([&](Index i, Scalar e, Scalar size) {
      ++n;
      if (const auto x = static_cast<double>(e / norm_.scale(0, i, size)); atol.is_sized(i)) others += x * x;
    });
    if (!(others <= allowed_ * allowed_ * static_cast<double>(n))) return found;
    each([&](Index i, Scalar e, Scalar size) {
      const Scalar shown = size > 0 ? size : e;
      if (atol.is_sized(i) || !(shown > 0) || !std::isfinite(shown) || (!reads_weights_ && e > shown)) return;
      atol.bear(i, shown);
    });
    return found;
  }
  /// Of the error allowed to a step: what its solves may leave of theirs.
  static constexpr double newton_share = 0.03;
  /// Where the force jumps, an estimate of one formula may be too small by this factor, squared.
  static constexpr double missed_square = 100;

  tolerance wanted_;
  iteration_control iterations_;
  bool has_end_ = false, counts_ = false, reads_weights_ = true, looks_for_jumps_ = false;
  int error_order_ = 2;
  ErrorNorm<Plain> norm_;
  StepSize size_;
  Trace<Plain> trace_;
  Measured error_;
  Doubt doubt_;
  Plain usual_, end_,
      error_before_;  // sizes for differences; of the last try, of that before a probe, where scales are the components' own
  double allowed_ = 1, per_allowed_ = 1;
};

}}  // namespace phistep::PHISTEP_ABI
