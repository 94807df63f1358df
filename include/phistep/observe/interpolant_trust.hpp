/// @file
/// How long a check of the interpolant holds. A check compares it with steps that end inside the step (run.hpp), which is
/// twice the work of the step itself: where its result was clear, it holds for 1, 2, 4 and then 8 steps, as long as Δt stays
/// about the same.
#pragma once

#include <algorithm>
#include <optional>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

class InterpolantTrust {
 public:
  /// Another step has been done.
  void step() {
    is_fresh_ = left_ > 0;
    left_ = std::max(left_ - 1, 0);
  }
  /// What the last check says of a step of this length; empty: it has to be checked. [time]
  [[nodiscard]] std::optional<bool> known(double dt) const {
    if (is_fresh_ && dt_ / 2 < dt && dt < 1.25 * dt_) return is_right_;
    return {};
  }
  /// A check has found the interpolant off by `error`, in units of the tolerance: right is half of that or less.
  bool check(double dt, double error) {
    is_right_ = error <= 0.5;
    // The error goes as Δt⁴ or faster: from a fifth of what is right it gets there by less than the 1.25 above, 1.25⁴ = 2.4.
    const bool is_clear = error <= 0.1 || !(error <= 2.5);
    steps_ = is_clear ? std::clamp(2 * steps_, 1, 8) : 0;
    left_ = steps_;
    dt_ = dt;
    is_fresh_ = true;
    return is_right_;
  }
  void forget() { *this = {}; }

  void archive(auto& ar) {
    ar(dt_, steps_, left_, is_right_, is_fresh_);
    ar.check(dt_ >= 0 && 0 <= left_ && left_ <= steps_ && steps_ <= 8);
  }

 private:
  double dt_ = 0;  // [time] of the step that was checked
  int steps_ = 0, left_ = 0;
  bool is_right_ = false, is_fresh_ = false;
};

}  // namespace phistep::inline PHISTEP_ABI
