/// @file
/// An observer that looks at regular intervals of time rather than after every step.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "phistep/base/version.hpp"
#include "phistep/run/observers/goes_on.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Calls f(t, state) at the first step end at or after each multiple of `interval` from the run's start, the start
/// itself included.
template <class F>
class Every {
 public:
  using ArchivedByParts = void;
  /// @throws std::invalid_argument unless the interval is finite and > 0.
  Every(double interval, F f) : interval_{interval}, f_(std::move(f)) {
    if (!(interval > 0) || !std::isfinite(interval))
      throw std::invalid_argument("phistep: every(interval, f) needs a finite interval > 0");
  }

  template <class Scalar, class S>
  bool operator()(Scalar t, S& state) {
    const double now = static_cast<double>(t);
    if (first_) start_ = now, first_ = false;
    // A step end that misses the mark by rounding alone counts as on it.
    const double slack = 64 * std::numeric_limits<Scalar>::epsilon() * (std::abs(start_) + std::abs(now));
    const double reach = std::abs(now - start_) + slack;
    if (reach < static_cast<double>(next_) * interval_) return true;
    // Not one by one: there may be 1e20 of them. Those that can't be counted are behind every step's end.
    next_ = std::max(next_, static_cast<long long>(std::min(reach / interval_, static_cast<double>(most))));
    while (next_ < most && static_cast<double>(next_) * interval_ <= reach) ++next_;
    return ask(f_, t, state);
  }
  /// Which mark it waits for, for a checkpoint.
  void archive(auto& ar) {
    ar("start", start_, "next", next_, "first", first_);
    ar.check(std::isfinite(start_) && 0 <= next_ && next_ <= most);
  }

 private:
  static constexpr long long most = 1LL << 53;

  double interval_;
  F f_;
  double start_ = 0;
  long long next_ = 0;  // the mark to wait for, in intervals
  bool first_ = true;
};

/// `integrate(…, every(0.1, [](double t, const auto& state) { … }))`. [time]
template <class F>
[[nodiscard]] auto every(double interval, F&& f) {
  static_assert(!copies_a_record<F>, "phistep: every(interval, recorder) would fill a copy: write std::ref(recorder)");
  return Every<std::decay_t<F>>{interval, std::forward<F>(f)};
}

}}  // namespace phistep::PHISTEP_ABI
