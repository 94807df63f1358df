/// @file
/// Observers at given times: the run stops there (`at_times`), is interpolated there (`sampled`), or observed at the first end of a
/// step from there on (`every`).
///
/// The first two take the times in any order, twice given ones count once, those outside the run are never reached and so
/// ignored. Runs may go backward. f(t, state) gets as t the very number given, and may return false to end the run.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/run/observers/completed_step.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Range>
concept TimeRange = requires(const Range& times) {
  requires std::is_arithmetic_v<std::remove_cvref_t<decltype(*times.begin())>>;
  times.end();
};

/// Times in order, each once. [time]
class TimeList {
 public:
  /// @throws std::invalid_argument where a time is not finite
  template <TimeRange Range = std::initializer_list<double>>
  explicit TimeList(const Range& times) {
    for (const auto t : times) times_.push_back(static_cast<long double>(t));
    for (const long double t : times_)
      if (!std::isfinite(t)) throw std::invalid_argument("phistep: the times to look at must be finite");
    std::sort(times_.begin(), times_.end());
  }
  template <class Scalar>
  [[nodiscard]] bool contains(Scalar t) const {
    const auto at = first_from(t);
    return at != times_.end() && static_cast<Scalar>(*at) == t;
  }
  /// The one next to t, strictly after it in the direction of dt.
  template <class Scalar>
  [[nodiscard]] std::optional<Scalar> next(Scalar t, Scalar dt) const {
    if (dt < 0) {
      const auto at = first_from(t);
      return at == times_.begin() ? std::nullopt : std::optional<Scalar>(static_cast<Scalar>(*(at - 1)));
    }
    const auto later = [](Scalar a, long double b) { return a < static_cast<Scalar>(b); };
    const auto at = std::upper_bound(times_.begin(), times_.end(), t, later);
    return at == times_.end() ? std::nullopt : std::optional<Scalar>(static_cast<Scalar>(*at));
  }

 private:
  template <class Scalar>
  [[nodiscard]] auto first_from(Scalar t) const {
    const auto earlier = [](long double a, Scalar b) { return static_cast<Scalar>(a) < b; };
    return std::lower_bound(times_.begin(), times_.end(), t, earlier);
  }
  std::vector<long double> times_;
};

/// Makes the run stop at given times, to the last bit. Keeps nothing from run to run, nor from step to step.
template <class F>
class AtTimes {
 public:
  AtTimes(TimeList times, F f) : times_(std::move(times)), f_(std::move(f)) {}

  /// Where the run has to stop next: strictly after t in the direction of dt.
  template <class Scalar>
  [[nodiscard]] std::optional<Scalar> next_stop(Scalar t, Scalar dt) const {
    return times_.next(t, dt);
  }
  template <class Scalar, class S>
  bool operator()(Scalar t, S& state) {
    return !times_.contains(t) || goes_on(f_, t, state);
  }

 private:
  TimeList times_;
  F f_;
};

/// t₀, t₀ ± interval, t₀ ± 2 interval, … of a run from t₀.
class IntervalMarks {
 public:
  /// @throws std::invalid_argument unless the interval is finite and > 0
  explicit IntervalMarks(double interval) : interval_{interval} {
    if (!(interval > 0) || !std::isfinite(interval))
      throw std::invalid_argument("phistep: every(interval, f) and sampled(interval, f) need a finite interval > 0");
  }
  void start(auto t0) {
    start_ = t0;
    next_ = 1;
  }
  /// @throws std::invalid_argument where the clock at t0 is coarser than the interval
  template <class Scalar>
  bool begin(Scalar t0) {
    if (interval_ < spacing(t0))
      throw std::invalid_argument(
          "phistep: sampled(interval, f): the interval is shorter than the distance of numbers at t0");
    start(t0);
    return true;
  }
  template <class Scalar>
  [[nodiscard]] std::optional<Scalar> next(Scalar dt) const {
    if (next_ >= most) return {};
    const auto whole = static_cast<Scalar>(next_) * static_cast<Scalar>(interval_);
    return static_cast<Scalar>(start_) + std::copysign(whole, dt);
  }
  void pass(auto /*mark*/) { ++next_; }
  /// Nothing before t is wanted any more.
  void skip(auto t) { skip_within(std::abs(static_cast<long double>(t) - start_)); }
  /// Whether t is at or after the next one, but for rounding. All those are passed.
  template <class Scalar>
  [[nodiscard]] bool reaches(Scalar t) {
    const auto now = static_cast<double>(t), from = static_cast<double>(start_);
    const double slack = 64 * std::numeric_limits<Scalar>::epsilon() * (std::abs(from) + std::abs(now));
    const double reach = std::abs(now - from) + slack;
    if (reach < static_cast<double>(next_) * interval_) return false;
    skip_within(reach);
    while (next_ < most && static_cast<double>(next_) * interval_ <= reach) ++next_;
    return true;
  }
  void archive(auto& ar) {
    ar("start", start_, "next", next_);
    ar.check(1 <= next_ && next_ <= most && std::isfinite(start_));
  }

 private:
  static constexpr long long most = 1LL << 53;
  /// Not one by one: there may be 1e20 of them, and beyond `most` they have no numbers.
  void skip_within(long double length) {
    next_ = std::max(next_, static_cast<long long>(std::min(length / interval_, static_cast<long double>(most))));
  }

  double interval_;
  long double start_ = 0;
  long long next_ = 1;
};

/// Calls f(t, state) at the first step end at or after each multiple of `interval` from the run's start, the start
/// itself included.
template <class F>
class Every {
 public:
  using ArchivedByParts = void;
  Every(IntervalMarks marks, F f) : marks_(marks), f_(std::move(f)) {}

  template <class Scalar, class S>
  bool operator()(Scalar t, S& state) {
    if (std::exchange(first_, false)) marks_.start(t);
    else if (!marks_.reaches(t)) return true;
    return call_and_ask(f_, t, state);
  }
  void archive(auto& ar) { ar("marks", marks_, "first", first_); }

 private:
  IntervalMarks marks_;
  F f_;
  bool first_ = true;
};

/// The given times of a run.
class ListMarks {
 public:
  explicit ListMarks(TimeList times) : times_(std::move(times)) {}
  template <class Scalar>
  bool begin(Scalar t0) {
    passed_ = t0;
    return times_.contains(t0);
  }
  template <class Scalar>
  [[nodiscard]] std::optional<Scalar> next(Scalar dt) const {
    return times_.next(static_cast<Scalar>(passed_), dt);
  }
  void pass(auto mark) { passed_ = mark; }
  static void skip(auto /*t*/) {}
  void archive(auto& ar) {
    ar("passed", passed_);
    ar.check(std::isfinite(passed_));
  }

 private:
  TimeList times_;
  long double passed_ = 0;
};

/// Shows f the state at marks inside of steps (CompletedStep::at), which moves no step. At a step's end that is the state
/// before edits.
template <class Marks, class F>
class Sampled {
 public:
  using ArchivedByParts = void;
  Sampled(Marks marks, F f) : marks_(std::move(marks)), f_(std::move(f)) {}

  /// A run starts at t0, maybe on a mark. False where f asks for its end.
  template <class Scalar, class S>
  bool begin(Scalar t0, const S& state) {
    return !marks_.begin(t0) || goes_on(f_, t0, state);
  }
  /// All marks of t0 < t ≤ t1.
  template <State S, bool has_inside>
  bool operator()(const CompletedStep<S, has_inside>& step) {
    // A mark that lies after the end by rounding alone is on it: there may be no further step.
    const auto slack = std::numeric_limits<ScalarOf<S>>::epsilon() * std::max(std::abs(step.t0()), std::abs(step.t1()));
    while (const auto mark = marks_.next(step.dt())) {
      if (step.dt() > 0 ? *mark > step.t1() + slack : *mark < step.t1() - slack) return true;
      marks_.pass(*mark);
      // An exception of f kept it from being shown with its own step: this one doesn't know it.
      if (step.dt() > 0 ? *mark < step.t0() - slack : *mark > step.t0() + slack) {
        marks_.skip(step.t0());
        continue;
      }
      if (!step.show(*mark, f_)) return false;
    }
    return true;
  }

  void archive(auto& ar) { ar("marks", marks_); }

 private:
  Marks marks_;
  F f_;
};

/// f, to be kept by value.
template <class F>
[[nodiscard]] std::decay_t<F> kept_copy(F&& f) {
  if constexpr (requires { typename std::remove_cvref_t<F>::KeepsStates; })
    static_assert(!std::is_lvalue_reference_v<F>,
                  "phistep: at_times, sampled or every would fill a copy: write std::ref(recorder)");
  return std::forward<F>(f);
}

/// `integrate(…, at_times({0.1, 0.25, 7}, [](double t, auto& state) { … }))`: steps end exactly at these times; f may edit
/// the state there. [time] A list in braces is one of doubles; where a state has longer ones, give a std::vector of them.
/// @throws std::invalid_argument where a time is not finite
template <TimeRange Range = std::initializer_list<double>, class F>
[[nodiscard]] auto at_times(const Range& times, F&& f) {
  return AtTimes(TimeList(times), kept_copy(std::forward<F>(f)));
}

/// `integrate(…, sampled(0.1, [](double t, const auto& state) { … }))`: at t0 and at every multiple of the interval from
/// there, without a stop (CompletedStep::at). [time]
/// @throws std::invalid_argument unless the interval is finite and > 0
template <class F>
[[nodiscard]] auto sampled(double interval, F&& f) {
  return Sampled(IntervalMarks(interval), kept_copy(std::forward<F>(f)));
}
/// The same at given times.
/// @throws std::invalid_argument where one is not finite
template <TimeRange Range = std::initializer_list<double>, class F>
[[nodiscard]] auto sampled(const Range& times, F&& f) {
  return Sampled(ListMarks(TimeList(times)), kept_copy(std::forward<F>(f)));
}

/// `integrate(…, every(0.1, [](double t, const auto& state) { … }))`. [time]
template <class F>
[[nodiscard]] auto every(double interval, F&& f) {
  return Every(IntervalMarks(interval), kept_copy(std::forward<F>(f)));
}

}}  // namespace phistep::PHISTEP_ABI
