/// @file
/// How long a check of the interpolant holds. A check compares it with steps that end inside the step (look_inside.hpp), which is
/// twice the work of the step itself: where its result was clear, it holds for 1, 2, then 4 steps, as long as Δt stays
/// about the same.
#pragma once

#include <algorithm>
#include <optional>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

class InterpolantTrust {
 public:
  /// Another step has been done.
  void step() {
    is_fresh_ = left_ > 0;
    left_ = std::max(left_ - 1, 0);
  }
  /// What the last check says of a step of this length; empty: it has to be checked. [time]
  [[nodiscard]] std::optional<bool> known(double dt) const {
    if (is_fresh_ && dt_ / 2 < dt && dt < 1.05 * dt_) return is_right_;
    return {};
  }
  /// A check has found the interpolant off by `error`, in units of the tolerance: right is half of that or less.
  bool check(double dt, double error) {
    is_right_ = error <= 0.5;
    // Clear is ten times less or more than that. The 1.05 above makes 1.05¹² = 1.8 of an error that goes as Δt¹².
    const bool is_clear = error <= 0.05 || !(error <= 5);
    steps_ = is_clear ? std::clamp(2 * steps_, 1, 4) : 0;
    left_ = steps_;
    dt_ = dt;
    error_ = error;
    is_fresh_ = true;
    return is_right_;
  }
  /// Into how many parts a step has to be divided for their interpolants to be right by the law of Δt⁴, 8 at most; 0: more.
  [[nodiscard]] int parts() const {
    for (const int m : {2, 4, 8})
      if (error_ <= 0.2 * m * m * m * m) return m;
    return 0;
  }
  void forget() { *this = {}; }

  void archive(auto& ar) {
    ar("dt", dt_, "error", error_, "steps", steps_, "left", left_, "is_right", is_right_, "is_fresh", is_fresh_);
    ar.check(dt_ >= 0 && 0 <= left_ && left_ <= steps_ && steps_ <= 4);
  }

 private:
  double dt_ = 0, error_ = 0;  // of the step that was checked [time], [tolerance]
  int steps_ = 0, left_ = 0;
  bool is_right_ = false, is_fresh_ = false;
};

/// In the interpolant of a whole step, and in those of its parts.
struct TrustInside {
  InterpolantTrust whole, parts;

  void step() { whole.step(), parts.step(); }
  void forget() { whole.forget(), parts.forget(); }
  void archive(auto& ar) { ar("whole", whole, "parts", parts); }
};

}}  // namespace phistep::PHISTEP_ABI
