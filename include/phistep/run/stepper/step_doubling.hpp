/// @file
/// The error of a step by doing it again in two halves (Hairer, Nørsett & Wanner, Solving ODEs I, sect. II.4, p. 164):
/// with y₁ after one step of Δt and y₂ after two of Δt/2, a scheme of order p leaves
///
///     y₂ − y(t+Δt) = (y₂ − y₁)/(1 − 2^p) + O(Δt^{p+2}).                                                         (1)
///
/// Three steps for two, and no demand on the scheme: it serves those that can't estimate their error, and the first step
/// of those that need the step before. The result is y₂, the better one.
#pragma once

#include <cmath>
#include <utility>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/run/stepper/any_stepper.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// `attempt` for any stepper.
template <class Stepper, State S>
class StepDoubling {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  void resize(const Plain& y) { start_ = whole_ = middle_ = next_ = y; }

  /// As PhiStepper::attempt. On rejection, failure and exception, state and stepper are what they were.
  /// @param halves  else the step is accepted as it is: it has no middle, or tells of nothing but rounding
  StepReport attempt(Stepper& stepper, S& state, Scalar t, Scalar dt, Origin origin, Trace<Plain>& trace,
                     const Judge<Plain>& accept, bool halves = true) {
    copy_blocks<S>(start_, state);
    Past<Stepper> past = past_of(stepper);
    bool half_way = false;
    const auto put_back = [&](auto&& to) {
      copy_blocks<S>(state, start_);
      go_back(stepper, std::forward<decltype(to)>(to));
      if (std::exchange(half_way, false)) trace.step_back();
    };
    // For good, and without allocating: it may be for want of memory.
    const auto take_back = [&] { put_back(std::move(past)); };
    try {
      StepReport report = one(stepper, state, t, dt, origin, trace);
      if (!report) return report;  // nothing has happened
      int iterations = report.iterations();
      bool is_right = true, ends = facts_of<Stepper>.traces;  // the next step can start where this one ends
      if (halves) {
        copy_blocks<S>(whole_, state);
        put_back(past);
        const Scalar half = dt / 2;
        for (const Scalar from : {t, t + half}) {
          if (from != t) {
            copy_blocks<S>(middle_, state);
            trace.advance();
            half_way = true;
          }
          const Origin part = from == t ? origin.first_part() : origin.last_part();
          report = one(stepper, state, from, half, part.with(Origin::unknown), trace);
          iterations += report.iterations();
          if (!report) {
            take_back();
            return report;
          }
        }
      }
      copy_blocks<S>(next_, state);
      if (halves) {
        const Scalar by = 1 / (std::exp2(static_cast<Scalar>(stepper.order())) - 1);
        assign<S>(trace.error, by * (in<S>(whole_) - in<S>(next_)));  // (1)
        trace.has_error = true;
        if (trace.has_unsized) {
          if (!reaches_end(stepper, t, dt, origin)) {
            take_back();
            return {failure_.outcome, iterations, &failure_};
          }
          ends = true;
          if constexpr (knows_slope) trace.rate = &whole_;
        }
        is_right = accept(std::as_const(start_), std::as_const(next_), trace);
      }
      if (is_right && (ends || reaches_end(stepper, t, dt, origin))) return {Outcome::success, iterations, nullptr};
      take_back();
      if (is_right) return {failure_.outcome, iterations, &failure_};
      return {Outcome::error_too_large, iterations, nullptr};
    } catch (...) {
      take_back();
      throw;
    }
  }
  /// The state half way through the last step accepted.
  [[nodiscard]] const Plain& middle() const { return middle_; }

 private:
  static constexpr bool knows_slope = requires(Stepper & stepper, Scalar t, Plain& y) {
    stepper.slope(t, std::as_const(y), y);
  };
  /// A step that is accepted as it is.
  static StepReport one(Stepper& stepper, S& state, Scalar t, Scalar dt, Origin origin, Trace<Plain>& trace) {
    const auto accepts_all = [](const auto&...) { return true; };
    if constexpr (facts_of<Stepper>.traces) return stepper.attempt(state, t, dt, origin, trace, accepts_all);
    else return do_step(stepper, state, t, dt, origin);
  }

  /// Whether the next step can start where this one ends: a force call, which a stepper that traces its steps has made.
  [[nodiscard]] bool reaches_end(Stepper& stepper, Scalar t, Scalar dt, const Origin& origin) {
    if constexpr (!knows_slope) {
      return true;
    } else {
      failure_ = {};
      failure_.t = static_cast<double>(t);
      failure_.dt = static_cast<double>(dt);
      failure_.outcome = slope_of<S>(stepper, Times<Scalar>{t, dt, origin}(t + dt), next_, whole_);
      return !failed(failure_.outcome);
    }
  }

  Plain start_, whole_, middle_, next_;
  Failure failure_;  // of an end that no step can start from
};

}}  // namespace phistep::PHISTEP_ABI
