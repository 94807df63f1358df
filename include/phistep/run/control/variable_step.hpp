/// @file
/// What both paces of a varying Δt are: a length, its bounds, where the next step is to land, and what a failed one does.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/control/limits.hpp"
#include "phistep/run/control/run_clock.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Scalar>
class VariableStep {
 public:
  static constexpr bool varies = true;

  /// |Δt| it would take next. [time]
  [[nodiscard]] double propose() const { return std::min(std::max(size_, smallest_), largest_); }
  /// Where the next step is to land, at a stop or before.
  [[nodiscard]] Landing<Scalar> plan(const RunClock<Scalar>& clock, std::optional<Scalar> stop) const {
    return clock.toward(stop.value_or(clock.span().t1), static_cast<Scalar>(propose()), static_cast<Scalar>(largest_));
  }
  [[nodiscard]] static bool is_at_end(const RunClock<Scalar>& clock) { return clock.is_at_end(); }
  /// After Outcome::invalid_tolerance.
  [[nodiscard]] const Refused& refused() const { return refused_; }
  /// One more try.
  [[nodiscard]] bool may_try() { return left_-- > 0; }

  void archive(auto& ar) {
    ar("size", size_, "left", left_, "failures", failures_);
    ar.check(size_ >= 0 && std::isfinite(size_) && -1 <= left_ && 0 <= failures_ && failures_ <= 21);
  }

 protected:
  [[nodiscard]] Outcome refuse(const Refused& what) {
    refused_ = what;
    return Outcome::invalid_tolerance;
  }
  [[nodiscard]] Outcome bound(double smallest, double largest, std::int64_t max_tries) {
    if (!(smallest >= 0)) return refuse({"min_step", smallest});
    if (!(largest > 0)) return refuse({"max_step", largest});
    if (!(smallest <= largest)) return refuse({"min_step, which exceeds max_step", smallest});
    if (max_tries < 0) return refuse({"max_steps", static_cast<double>(max_tries)});
    smallest_ = smallest;
    largest_ = largest;
    left_ = max_tries;
    return Outcome::success;
  }
  [[nodiscard]] bool is_capped() const { return size_ >= largest_; }
  /// The length after a step that is done, or of the first.
  void set(double size) {
    size_ = size;
    failures_ = 0;
  }
  /// A step of length dt is not to be: shorter ones, or the end.
  [[nodiscard]] Outcome shorten(Outcome why, double dt, double by) {
    if (why != Outcome::error_too_large && ++failures_ > 20) return why;
    size_ = by * dt;
    // At t = 0 the clock goes on for ever.
    const bool is_none = size_ < static_cast<double>(least_normal<Scalar>);
    return size_ < smallest_ || is_none ? Outcome::step_too_small : Outcome::success;
  }

 private:
  double size_ = 0, smallest_ = 0, largest_ = std::numeric_limits<double>::infinity();
  std::int64_t left_ = 0;
  int failures_ = 0;
  Refused refused_;
};

}}  // namespace phistep::PHISTEP_ABI
