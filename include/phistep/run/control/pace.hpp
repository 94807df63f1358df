/// @file
/// How long the steps of a run are: what a Run asks between its steps. A pace that varies
///
///     Outcome begin(y, law)                    reads the options
///     Outcome start(span, y, order, slope)     chooses a first length; slope(t, y, out) costs a force call
///     double propose()                         |Δt| it would take next
///     bool is_at_end(clock), may_try()         whether the run is done; whether there may be another try
///     Landing plan(clock, stop)                where the next step is to land, at a stop or before
///     prepare(y, dt), (y, y⁺, trace)           before an attempt, and in it, where it wants to see the error: it is its judge
///     accepted(to, record, limits)            the step has become the state
///     Outcome failed(outcome, to, …)           success: try again with what plan() says now
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/run/control/iteration_control.hpp"
#include "phistep/run/control/rounding_probe.hpp"
#include "phistep/run/control/run_clock.hpp"
#include "phistep/run/control/run_report.hpp"
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
      return Length::refuse(wanted_.rtol > 0 && wanted_.rtol < 1
                                ? Refused{"atol (its values, how many, what quantity(...) counts), or the norm"}
                                : Refused{"rtol", wanted_.rtol});
    size_ = {};
    obey(law);
    // An error below 8 units of rounding may be nothing else; below 64 where high orders combine their stages with weights
    // of up to a hundred.
    const double least = (law.error_order <= law.order ? 64 : 8) * round_off;
    if (wanted_.rtol * std::min(allowed_, 1.0) < least)
      return Length::refuse({"rtol, which is below rounding", wanted_.rtol,
                             std::pow(least, std::min(1.0, law.order / static_cast<double>(law.error_order)))});
    if (!(wanted_.first_step >= 0)) return Length::refuse({"first_step", wanted_.first_step});
    if (const char* bad = counts_ ? what_cannot_work(iterations_) : nullptr) return Length::refuse({bad});
    trace_.resize(y);
    trace_.rtol = wanted_.rtol;
    trace_.has_met_bound = false;
    probe_.begin();
    if (keeps_sizes()) keep_room(y);
    return Length::bound(std::max(wanted_.min_step, counts_ ? iterations_.min_step : wanted_.min_step),
                         std::min(wanted_.max_step, counts_ ? iterations_.max_step : wanted_.max_step),
                         std::min(wanted_.max_steps, counts_ ? iterations_.max_steps : wanted_.max_steps));
  }
  [[nodiscard]] Outcome start(TimeSpan<Scalar> span, const Plain& y, int order, auto&& slope) {
    double first = wanted_.first_step;
    if (first == 0) {
      norm_.weigh(y, trace_.weight);
      first = first_step(slope, y, trace_.weight, span.t0, span.t1 - span.t0, order, allowed_);
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
  [[nodiscard]] AutomaticAtol<Plain>& sizes() { return norm_.automatic(); }

  [[nodiscard]] Trace<Plain>& trace() { return trace_; }
  void prepare(const Plain& y, double dt) {
    error_ = {};
    if (norm_.is_automatic()) norm_.automatic().begin_try(dt);
    trace_.proposed = 0;
    trace_.rate = nullptr;
    away_.reset();
    // Without a scale for each component, a solve's own error can't be weighed: then to rounding.
    trace_.weighs_most = false;
    if (!reads_weights_) {
      norm_.remember(y);
    } else {
      const bool weighs_all = norm_.weigh(y, trace_.weight);
      const double spread = norm_.spread(y);
      trace_.newton_target = weighs_all ? newton_share * allowed_ / spread : 0;
      trace_.weighs_most = weighs_all && spread == 1 && !norm_.is_automatic();
    }
    trace_.usual = nullptr;
    if constexpr (knows_rounding)
      if (reads_weights_ && norm_.is_automatic()) {
        norm_.automatic().tell_usual(usual_);
        trace_.usual = &usual_;
      }
    trace_.has_unsized = knows_rounding && norm_.is_automatic() && !norm_.automatic().all_sized();
  }
  /// Whether the step's error is allowed.
  [[nodiscard, gnu::always_inline]] inline bool operator()(const Plain& y, const Plain& next,
                                                           const Trace<Plain>& told) {
    error_ = measure(told, y, next);
    if (knows_rounding && probe_.is_probing()) return false;
    error_.square *= told.error_scale_square;
    if (looks_for_jumps_ && !trace_.smoothness.holds(error_.square, static_cast<double>(told.dt), error_order_))
      error_.square *= missed_square;
    // A scheme that proposes Δt has judged.
    const bool is_allowed = trace_.proposed != 0 || error_.square <= allowed_ * allowed_;
    if (!is_allowed || !knows_rounding || !norm_.is_automatic()) return is_allowed;
    return !probe_.is_due(error_.square >= 0.01 * allowed_ * allowed_);
  }
  /// Whether what failed the last try may be rounding: then it is to be tried again from a state a rounding away.
  [[nodiscard]] bool doubts(Outcome why, const Landing<Scalar>& to) {
    if (!keeps_sizes() || away_.value_or(-1) >= 0) return false;
    if (why == Outcome::error_too_large) return probe_.has_failed(std::abs(static_cast<double>(to.dt)), error_.size());
    probe_.has_stalled();
    if constexpr (knows_rounding) norm_.automatic().unbear();
    return false;
  }
  [[nodiscard]] bool knows_rates() const { return keeps_sizes() && probe_.knows_rates(); }
  /// trace().error holds y' where a solve has failed, trace().end the same after some roundings of y.
  void learn_rates(Scalar dt) {
    if constexpr (knows_rounding) probe_.learn_rates(norm_.automatic(), trace_.error, trace_.end, dt);
  }
  /// The next try starts from the state left in trace().predicted: its end tells of rounding. @param iterates  steps are solved by
  /// iteration
  void begin_probe(const Plain& y, bool iterates) {
    copy_blocks<Plain>(trace_.predicted, y);
    const std::uint64_t number = probe_.start(iterates, error_, trace_);
    move_numbers(trace_.predicted, number, probe_.moved_by());
  }
  void end_probe() { probe_.end(error_, trace_); }
  /// ‖e‖ that a step may have, in units of the tolerance
  [[nodiscard]] double allowed() const { return allowed_; }
  /// ‖e‖ in units of the tolerance, where e is what a state between y and next is off.
  [[nodiscard]] double size(const Plain& e, const Plain& y, const Plain& next) const {
    return norm_(e, y, next).size();
  }
  /// That of the try in hand, which teaches sizes: a probe that begins with a check of its start isn't that check.
  [[nodiscard]] double size_of_error(const Plain& y, const Plain& next, const Trace<Plain>& told) {
    return measure(told, y, next).size();
  }
  // A pace that is const judges steps that are not the one in hand: they teach nothing.
  [[nodiscard]] double size_of_error(const Plain& y, const Plain& next, const Trace<Plain>& told) const {
    return size(told.error, y, next);
  }
  [[nodiscard]] bool operator()(const Plain& y, const Plain& next, const Trace<Plain>& told) const {
    return told.proposed != 0 || std::sqrt(told.error_scale_square) * size(told.error, y, next) <=
                                     allowed_;  // a scheme that proposes Δt has judged
  }
  [[gnu::always_inline]] inline void accepted(const Landing<Scalar>& to, const SolveRecord& record, Limits& limits) {
    const double dt = std::abs(static_cast<double>(to.dt));
    const double proposed = std::exchange(trace_.proposed, 0);
    trace_.advance();
    if (norm_.is_automatic()) {
      if constexpr (knows_rounding) tell(limits);
      norm_.automatic().accepted();
      probe_.end_step();
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
    if (probe_.takes_back()) return Length::shorten(why, dt, 0.9);
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
    damps_ = law.damps;
    looks_for_jumps_ = law.looks_for_jumps;
    error_order_ = law.error_order;
    allowed_ = law.error_order == law.order
                   ? 1
                   : std::pow(wanted_.rtol, (law.error_order - law.order) / static_cast<double>(law.order));
    per_allowed_ = 1 / allowed_;
    probe_.obey(law.damps, wanted_.rtol, allowed_);
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
        if (norm_.is_automatic()) probe_.edited(norm_.automatic(), y);
      return true;
    }
    trace_.resize(y);
    if (keeps_sizes()) keep_room(y);
    if (norm_.fits(y)) return true;
    static_cast<void>(Length::refuse({"atol, which is for a state of another size"}));
    return false;
  }

  void archive(auto& ar) {
    ar("norm", norm_, "filter", size_, "step", static_cast<Length&>(*this), "trace", trace_, "probe", probe_);
  }

 private:
  static constexpr bool knows_rounding = !FieldState<Plain>;

  void keep_room(const Plain& y) {
    usual_ = y;
    probe_.resize(y);
  }
  [[nodiscard, gnu::always_inline]] inline Measured measure(const Trace<Plain>& told, const Plain& y,
                                                            const Plain& next) {
    if constexpr (knows_rounding)
      if (norm_.is_automatic()) return measure_by_sizes(told, y, next);
    return norm_(told.error, y, next);
  }
  [[nodiscard, gnu::noinline]] Measured measure_by_sizes(const Trace<Plain>& told, const Plain& y, const Plain& next) {
    const Measured found = norm_(told.error, y, next);
    if (probe_.is_probing()) {
      probe_.learn(norm_, told, y, next);
      return {std::numeric_limits<double>::infinity(), {}};
    }
    probe_.remember_end(next);
    if (norm_.automatic().all_sized()) return found;
    if (const Index i = runs_away(told, next); i >= 0) return {blown_up, component(i)};
    learn_sizes(told.error, y, next);
    return norm_.automatic().has_begun_before() ? norm_(told.error, y, next) : found;
  }
  /// A component that had no size, and that the step has not made but blown up; −1: none. What begins as t^k has a rate of k y⁺/Δt, in
  /// a shorter try with the same k; the rate after an unstable step is against y⁺ or far more, and less so after a shorter one.
  [[nodiscard]] Index runs_away(const Trace<Plain>& told, const Plain& next) {
    if (told.rate == nullptr) return -1;
    if (away_) return *away_;
    Index found = -1;
    auto& atol = norm_.automatic();
    for_each_number(
        [&](std::size_t at, Scalar to, Scalar rate, Scalar start) {
          const auto i = static_cast<Index>(at);
          if (to != 0 && !atol.is_sized(i) && !atol.begins(i, to, told.dt * rate, told.dt * start, damps_)) found = i;
        },
        Blocks<Plain>::all(next), Blocks<Plain>::all(*told.rate), Blocks<Plain>::all(told.start));
    away_ = found;
    return found;
  }
  /// The i-th number over all blocks.
  [[nodiscard]] Component component(Index i) const {
    Component found;
    for_each_block(
        [&](auto k, const auto& block) {
          if (found.block < 0 && i < block.size()) found = {static_cast<std::int64_t>(k()), i};
          i -= block.size();
        },
        Blocks<Plain>::all(trace_.weight));
    return found;
  }
  [[gnu::noinline]] void tell(Limits& limits) const {
    limits.has_own_scales = true;
    if (const Index i = norm_.automatic().below(); i >= 0) limits.below.name(component(i));
    if (const Index i = norm_.automatic().leapt(); i >= 0) limits.leapt.name(component(i));
  }
  /// Where the others are right, components that had no size have one now.
  [[gnu::noinline]] void learn_sizes(const Plain& error, const Plain& y, const Plain& next) {
    auto& atol = norm_.automatic();
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
    if (!(others <= allowed_ * allowed_ * static_cast<double>(n))) return;
    each([&](Index i, Scalar e, Scalar size) {
      const Scalar shown = size > 0 ? size : e;
      if (atol.is_sized(i) || !(shown > 0) || !std::isfinite(shown) || (!reads_weights_ && e > shown)) return;
      atol.bear(i, shown);
    });
  }
  /// ‖e‖² of a try that has blown something up.
  static constexpr double blown_up = 1e20;
  /// Of the error allowed to a step: what its solves may leave of theirs.
  static constexpr double newton_share = 0.03;
  /// Where the force jumps, an estimate of one formula may be too small by this factor, squared.
  static constexpr double missed_square = 100;

  tolerance wanted_;
  iteration_control iterations_;
  bool counts_ = false, reads_weights_ = true, damps_ = false, looks_for_jumps_ = false;
  int error_order_ = 2;
  ErrorNorm<Plain> norm_;
  StepSize size_;
  Trace<Plain> trace_;
  Measured error_;
  std::optional<Index> away_;  // what runs_away() has found in this try
  RoundingProbe<Plain> probe_;
  Plain usual_;  // sizes for differences, where scales are the components' own
  double allowed_ = 1, per_allowed_ = 1;
};

}}  // namespace phistep::PHISTEP_ABI
