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
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/run/control/run_clock.hpp"
#include "phistep/run/control/run_report.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// A first Δt from what the solution does at the start: an Euler step tells y'' (Hairer, Nørsett & Wanner, Solving ODEs I,
// sect. II.4, p. 169), and with τ = ‖y'‖/‖y''‖ for the time in which it changes, a step of order p errs by about
//
//     ‖e‖ ≈ ‖y'‖ Δt (Δt/τ)^p.                                                                                   (1)
//
// Unlike the book's, this rule has the right dimensions: the unit of time changes nothing.

/// @param slope    slope(t, y, out) → bool: out = y', false where that isn't finite
/// @param length   [time] of the run, with its sign
/// @param order    of the scheme
/// @param allowed  ‖e‖ that a step may have
/// @return |Δt| ≤ |length|; 0 where y' isn't finite at the start. Two force calls.
template <State Plain>
[[nodiscard]] double first_step(auto&& slope, const Plain& y, const Plain& weight, ScalarOf<Plain> t,
                                ScalarOf<Plain> length, int order, double allowed) {
  using Scalar = ScalarOf<Plain>;
  const auto norm = [&weight](const Plain& x) { return weighted_rms(x, weight); };
  const double run = std::abs(static_cast<double>(length));
  Plain f0 = y, f1 = y, probe = y;
  if (!slope(t, y, f0)) return 0;
  const double size = norm(y), speed = norm(f0), scale = std::max(size, allowed);
  const bool moves = speed * run > 1e-10 * scale;  // what moves less in all of the run is at rest
  // The probe moves a hundredth of y, or where y is nothing beside atol, a hundredth of the error allowed.
  double h = moves ? std::min(run, 0.01 * scale / speed) : 1e-6 * run;
  double change = -1;
  for (int tries = 0; tries < 40 && change < 0; ++tries) {
    const Scalar signed_h = static_cast<Scalar>(std::copysign(h, static_cast<double>(length)));
    assign<Plain>(probe, in<Plain>(y) + signed_h * in<Plain>(f0));
    if (slope(t + signed_h, probe, f1)) {
      assign<Plain>(f1, in<Plain>(f1) - in<Plain>(f0));
      change = norm(f1);
    } else {
      h /= 16;  // the probe left the force's domain
    }
  }
  if (!(change > 0)) return std::min(100 * h, run);
  // In units of h, so that every power is of a number without dimension.
  int exponent = 0;  // ‖y''‖ h² without a square of h
  const double m = std::frexp(h, &exponent);
  const double p = order, moved = speed * h, bent = std::ldexp(change / m * m * m, exponent);
  // (0.1 ‖e‖/moved (moved/bent)^p)^{1/(p+1)}
  const double wanted = moves
                            ? h * std::exp2((std::log2(0.1 * allowed / moved) - p * std::log2(bent / moved)) / (p + 1))
                            : h * std::sqrt(0.1 * allowed / bent);
  return std::min({100 * h, wanted, run});
}

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
  /// After a step of length dt that failed: the next is by·dt long. Not success: that is too short, or too many failed.
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
