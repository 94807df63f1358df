/// @file
/// How long the steps of a run are: what a Run asks between its steps. A pace that varies
///
///     Outcome begin(y, law)                    reads the options
///     Outcome start(span, y, order, slope)     chooses a first length; slope(t, y, out) costs a force call
///     double propose()                         |Δt| it would take next
///     bool is_at_end(clock), may_try()         whether the run is done; whether there may be another try
///     Landing plan(clock, stop)                where the next step is to land, at a stop or before
///     prepare(y, dt), judge(…)                 before and inside an attempt, where it wants to see the error
///     accepted(to, history, limits)            the step has become the state
///     Outcome failed(outcome, to, …)           success: try again with what plan() says now
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/control/first_step.hpp"
#include "phistep/run/control/fixed_step.hpp"
#include "phistep/run/control/iteration_control.hpp"
#include "phistep/run/control/limits.hpp"
#include "phistep/run/control/run_clock.hpp"
#include "phistep/run/control/variable_step.hpp"
#include "phistep/run/errors/error_norm.hpp"
#include "phistep/run/errors/step_filter.hpp"
#include "phistep/run/errors/tolerance.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// How the error of a scheme's steps goes with their length, and what a new length costs.
struct ErrorLaw {
  int order = 1;                          ///< of the scheme
  int error_order = 2;                    ///< the power of Δt with which its estimate goes
  double dead_band = 1;                   ///< see StepSize; more than 1 where a kept Δt spares a factorization
  bool reads_weights = true;              ///< steps read trace.weight
  StepFilter filter = StepFilter::H211b;  ///< the one that suits, unless the user names another
  bool looks_for_jumps = false;           ///< its estimate falls as that power, or the force isn't smooth (Smoothness)
};

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
      return Length::refuse(wanted_.rtol > 0 && wanted_.rtol < 1 ? "atol, or the norm" : "rtol");
    size_ = {};
    obey(law);
    // An error of a few roundings can't be told from rounding; where stages are combined with weights of up to a hundred,
    // as high orders do, one of some dozens.
    const double least = (law.error_order <= law.order ? 64 : 8) * round_off;
    if (wanted_.rtol * std::min(allowed_, 1.0) < least) return Length::refuse("rtol, which is below rounding");
    if (!(wanted_.first_step >= 0)) return Length::refuse("first_step");
    if (const char* bad = counts_ ? what_cannot_work(iterations_) : nullptr) return Length::refuse(bad);
    trace_.resize(y);
    trace_.rtol = wanted_.rtol;
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

  [[nodiscard]] Trace<Plain>& trace() { return trace_; }
  void prepare(const Plain& y, double dt) {
    error_ = {};
    norm_.begin_try(dt);
    trace_.proposed = 0;
    // Without a scale for each component, a solve's own error can't be weighed: then to rounding.
    if (!reads_weights_) norm_.remember(y);
    else trace_.newton_target = norm_.weigh(y, trace_.weight) ? newton_share * allowed_ / norm_.spread(y) : 0;
    trace_.norm = &norm_;
    trace_.measure = [](void* norm, const Plain& error, const Plain& from, const Plain& to) {
      return (*static_cast<ErrorNorm<Plain>*>(norm))(error, from, to).size();
    };
  }
  /// Whether the step's error is allowed.
  [[nodiscard, gnu::always_inline]] inline bool judge(const Plain& y, const Plain& next, const Trace<Plain>& told) {
    error_ = norm_(told.error, y, next);
    error_.square *= told.error_scale_square;
    if (looks_for_jumps_ && !trace_.smoothness.holds(error_.square, static_cast<double>(told.dt), error_order_))
      error_.square *= missed_square;
    return trace_.proposed != 0 || error_.square <= allowed_ * allowed_;  // a scheme that proposes Δt has judged
  }
  /// ‖e‖ in units of the tolerance, where e is what a state between y and next is off.
  [[nodiscard]] double size(const Plain& y, const Plain& next, const Plain& e) { return norm_(e, y, next).size(); }
  /// Whether the error of a step that is not the one in hand is allowed.
  [[nodiscard]] bool allows(const Plain& y, const Plain& next, const Trace<Plain>& told) {
    return told.proposed != 0 || std::sqrt(told.error_scale_square) * size(y, next, told.error) <=
                                     allowed_;  // a scheme that proposes Δt has judged
  }
  [[gnu::always_inline]] inline void accepted(const Landing<Scalar>& to, const Failure& history, Limits& limits) {
    const double dt = std::abs(static_cast<double>(to.dt));
    const double proposed = std::exchange(trace_.proposed, 0);
    trace_.advance();
    const bool was_capped = Length::is_capped();
    double by = proposed > 0 ? proposed / dt : size_.accepted_square(error_.square * per_allowed_ * per_allowed_);
    bool by_iterations = false;
    if (counts_) {
      const double lambda = iteration_factor(history, iterations_);
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
  [[nodiscard]] Outcome failed(Outcome why, const Landing<Scalar>& to, const Failure&, Limits& limits) {
    const double dt = std::abs(static_cast<double>(to.dt));
    if (const double proposed = std::exchange(trace_.proposed, 0); proposed > 0 && proposed < dt)
      return Length::shorten(why, dt, proposed / dt);
    if (why == Outcome::error_too_large) return Length::shorten(why, dt, size_.rejected(error_.size() / allowed_));
    if (!may_be_cured(why)) return why;
    const bool is_finite = why != Outcome::non_finite_force && why != Outcome::non_finite_state;
    limits.count(is_finite ? LimitedBy::iterations : LimitedBy::not_finite);
    size_.forget();
    return Length::shorten(why, dt, 0.25);
  }
  /// The steps to come are another scheme's, which knows nothing of those before. @param longest  [time] of the first
  void change(const ErrorLaw& law, double longest) {
    obey(law);
    size_.forget();
    trace_.forget();
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
  /// The state isn't what the last step left. False where it outgrew the tolerances given.
  [[nodiscard]] bool edited(const Plain& y) {
    size_.forget();
    trace_.forget();
    if (same_shape<Plain>(trace_.weight, y)) return true;
    trace_.resize(y);
    if (norm_.fits(y)) return true;
    static_cast<void>(Length::refuse("atol, which is for a state of another size"));
    return false;
  }

  void archive(auto& ar) { ar("norm", norm_, "filter", size_, "step", static_cast<Length&>(*this), "trace", trace_); }

 private:
  /// Of the error allowed to a step: what its solves may leave of theirs.
  static constexpr double newton_share = 0.03;
  /// Where the force jumps, an estimate of one formula may be too small by this factor, squared.
  static constexpr double missed_square = 100;

  tolerance wanted_;
  iteration_control iterations_;
  bool counts_ = false, reads_weights_ = true, looks_for_jumps_ = false;
  int error_order_ = 2;
  ErrorNorm<Plain> norm_;
  StepSize size_;
  Trace<Plain> trace_;
  Measured error_;
  double allowed_ = 1, per_allowed_ = 1;
};

/// `iteration_control{…}` alone.
template <State S>
class IterationPace : public VariableStep<ScalarOf<S>> {
  using Length = VariableStep<ScalarOf<S>>;

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  static constexpr bool sees_error = false;

  explicit IterationPace(const iteration_control& wanted) : wanted_{wanted} {}
  [[nodiscard]] Outcome begin(const Plain&, const ErrorLaw&) {
    if (!(wanted_.first_step > 0)) return Length::refuse("first_step of the iteration_control");
    if (const char* bad = what_cannot_work(wanted_)) return Length::refuse(bad);
    return Length::bound(wanted_.min_step, wanted_.max_step, wanted_.max_steps);
  }
  [[nodiscard]] Outcome start(TimeSpan<Scalar> span, const Plain&, int, auto&&) {
    Length::set(std::min(wanted_.first_step, std::abs(static_cast<double>(span.t1 - span.t0))));
    return Outcome::success;
  }
  void accepted(const Landing<Scalar>& to, const Failure& history, Limits& limits) {
    const bool was_capped = Length::is_capped();
    const double next = iteration_factor(history, wanted_) * std::abs(static_cast<double>(to.dt));
    Length::set(to.clipped ? std::max(Length::propose(), next) : next);
    limits.count(to.clipped ? LimitedBy::stop : was_capped ? LimitedBy::max_step : LimitedBy::iterations);
  }
  [[nodiscard]] Outcome failed(Outcome why, const Landing<Scalar>& to, const Failure& history, Limits&) {
    if (!may_be_cured(why)) return why;
    return Length::shorten(why, std::abs(static_cast<double>(to.dt)),
                           std::min(0.5, iteration_factor(history, wanted_)));
  }

  void archive(auto& ar) { ar("step", static_cast<Length&>(*this)); }

 private:
  iteration_control wanted_;
};

}}  // namespace phistep::PHISTEP_ABI
