/// @file
/// The time of a run, and where its next step is to land.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A run from t0 to t1, forward or backward. [time]
template <class Scalar>
struct TimeSpan {
  Scalar t0, t1;
};

/// What one step tries, or several of one length.
template <class Scalar>
struct Landing {
  Scalar end;            ///< [time] where it lands, the very number
  Scalar dt;             ///< [time] nominal
  bool lands;            ///< `end` is a number given, not t + dt
  bool clipped;          ///< shorter than the pace wanted
  bool is_node = false;  ///< `end` is a node of a fixed grid
  std::int64_t steps = 1;
  bool at_stop = false;  ///< `end` is a time where a step was to end: there a force may jump
};

template <class Scalar>
class RunClock {
 public:
  explicit RunClock(TimeSpan<Scalar> span) : span_{span}, t_{span.t0} {}

  [[nodiscard]] Scalar t() const { return t_; }  ///< [time]
  [[nodiscard]] const TimeSpan<Scalar>& span() const { return span_; }
  [[nodiscard]] bool is_at_end() const { return t_ == span_.t1; }
  /// The way that the run goes: 1 or −1.
  [[nodiscard]] Scalar sign() const { return span_.t1 < span_.t0 ? Scalar{-1} : Scalar{1}; }
  /// From where the run stands to t, with what the sum of its steps has lost.
  [[nodiscard]] Scalar length_to(Scalar t) const { return t - t_ + lost_; }
  /// Times this near each other are one: by so much nodes and given times are off their numbers.
  [[nodiscard]] Scalar rounding(Scalar t) const {
    return std::numeric_limits<Scalar>::epsilon() * (std::abs(t) + std::abs(t - span_.t0));
  }
  /// A step of the wanted length or, near to a stop, of about that.
  /// @param longest  that no step may exceed
  [[nodiscard]] Landing<Scalar> toward(Scalar stop, Scalar wanted, Scalar longest) const {
    const Scalar left = sign() * length_to(stop);
    // A stretch by a hundredth spares a tiny last step; two halves are better than one step and a bit.
    const Scalar stretched = std::min(static_cast<Scalar>(1.01) * wanted, longest);
    if (left <= std::max(wanted, stretched) + rounding(stop))
      return {.end = stop, .dt = sign() * left, .lands = true, .clipped = wanted > left, .at_stop = true};
    if (left < 2 * wanted) return {t_ + sign() * left / 2, sign() * left / 2, false, true};
    return {t_ + sign() * wanted, sign() * wanted, false, false};
  }
  /// t + Δt by a compensated sum (W. Kahan, Comm. ACM 8 (1965) 40), or the number to land on.
  void move(const Landing<Scalar>& to) {
    if (to.lands) {
      t_ = to.end;
      lost_ = Scalar{0};
      return;
    }
    const Scalar by = to.dt - lost_, sum = t_ + by;
    lost_ = (sum - t_) - by;
    t_ = sum;
  }

  /// It lies within the span, and what its sum has lost is a rounding of it.
  void archive(auto& ar) {
    ar("t", t_, "lost", lost_);
    ar.check(std::min(span_.t0, span_.t1) <= t_ && t_ <= std::max(span_.t0, span_.t1));
    const Scalar largest = std::max(std::abs(span_.t0), std::abs(span_.t1));
    ar.check(std::abs(lost_) <= 2 * std::numeric_limits<Scalar>::epsilon() * largest);
  }

 private:
  TimeSpan<Scalar> span_;
  Scalar t_, lost_{0};
};

}}  // namespace phistep::PHISTEP_ABI
