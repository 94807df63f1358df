/// @file
/// When an iteration has done enough, judged by the sizes of its corrections. With θ = ‖δ_k‖/‖δ_{k−1}‖ an iteration that
/// contracts has after its k-th correction an error of
///
///     θ/(1−θ) ‖δ_k‖      (Hairer & Wanner, Solving ODEs II, sect. IV.8, p. 120)                                      (1)
///
/// Two ways to stop:
/// - to rounding (default): where (1) is below the unit round-off, or where ‖δ‖ has stopped falling at the noise that
///   rounding in Ψ makes (conservative runs drift otherwise);
/// - to a tolerance: RADAU5's test in the weighted RMS norm, with its fnewt (HW II p. 120-121).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/numbers/arithmetic.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a correction says of its iteration: it contracts; it is done; it contracts too slowly, or not at all.
enum class Judgement { go_on, converged, slow, growing };

/// The size of one correction δ.
struct Correction {
  double relative = 0;    ///< ‖δ‖/‖Y‖ in solves to rounding, else ‖δ‖ in the weighted RMS norm
  double beside_all = 0;  ///< ‖δ‖ relative to everything that rounding may have touched: Y, its base, r/γ
  double absolute = 0;    ///< ‖δ‖ itself
  bool is_new = false;    ///< part of it is a component that was 0 until now: nothing to be compared with
};

/// δ relative to the size of what it corrects, 1 where that is nothing. Subnormal numbers are all rounded alike: there, it is
/// relative to the least normal one.
template <class Scalar>
[[nodiscard]] double relative_size(double delta, double size) {
  return size > 0 ? delta / at_least_normal<Scalar>(size) : 1.0;
}

/// (1)
[[nodiscard]] inline double error_left(double theta, double size) {
  return theta < 1 ? theta / (1 - theta) * size : std::numeric_limits<double>::infinity();
}
/// Corrections this small, ‖δ‖ ≤ u^⅔, that no longer fall are rounding in Ψ; those of a cycle or a divergence are of order one.
[[nodiscard]] inline bool may_be_rounding(double size, double round_off) {
  return size * size * size <= round_off * round_off;  // without the price of a root for every small system
}
/// A step's relative tolerance, for the equations inside it: RADAU5's rescaling, in whose units 1 is what a step may be off.
[[nodiscard]] inline double solve_rtol(double rtol) { return 0.1 * std::cbrt(rtol * rtol); }
/// The part of that which the solve may be off: RADAU5's fnewt; 0 for rtol = 0, to rounding.
[[nodiscard]] inline double solve_target(double rtol, double round_off) {
  if (rtol == 0) return 0;
  const double reduced = solve_rtol(rtol);
  return std::max(10 * round_off / reduced, std::min(0.03, std::sqrt(reduced)));
}
/// The part of a nonlinear solve's error that an iterative linear solver may leave (Hindmarsh et al., ACM Trans. Math. Softw. 31
/// (2005) 363, sect. 2.1).
inline constexpr double inexact_share = 0.05;

/// The judge of one solve by Newton's iteration.
class ConvergenceTest {
 public:
  /// For a controlled run. @param rate  θ/(1−θ) as the solves before left it: the first correction may then be the last
  /// (HW II, p. 121, with its exponent, which makes an old rate count less and less).
  ConvergenceTest(double target, int max_iterations, double rate, double round_off)
      : round_off_{round_off}, target_{target}, limit_{max_iterations > 0 ? max_iterations : 7} {
    // One fast solve does not predict the next: rates below 1e-5 count as 1e-5.
    rate_ = std::pow(std::max(rate, 1e-5), 0.8);
  }

  /// To rounding or to the options' tolerance. @param last_rate  first_rate() of the solve before, 0: there was none
  ConvergenceTest(const NewtonOptions& options, double round_off, double last_rate = 0)
      : round_off_{round_off}, target_{solve_target(options.rtol, round_off)} {
    limit_ = options.max_iterations > 0 ? options.max_iterations : target_ > 0 ? 7 : 25;
    if (target_ == 0) last_rate_ = last_rate > 0 ? last_rate : slow_rate;
  }

  /// Whether there may be a k-th correction.
  [[nodiscard]] bool allows(int k) const { return k - in_vain_ <= limit_; }
  [[nodiscard]] bool is_to_rounding() const { return target_ == 0; }
  /// θ/(1−θ), for the next solve.
  [[nodiscard]] double rate() const { return rate_; }
  /// ‖δ_2‖/‖δ_1‖ of the solve, 0: not known. Where it is small, the matrix may serve the next step, too.
  [[nodiscard]] double first_rate() const { return first_rate_; }
  /// Whether it judges by the rate of an earlier solve.
  [[nodiscard]] bool has_past() const { return last_rate_ != 0 && last_rate_ != slow_rate; }
  /// The first k corrections don't count.
  void start_over(int k) {
    forget();
    in_vain_ = k;
  }
  /// The next correction has nothing to be compared with.
  void forget() {
    previous_ = 0;
    if (target_ == 0) last_rate_ = slow_rate;
  }

  /// @param trusted  the matrix was made in this solve, or the residual was nothing but rounding: a small correction
  ///                 then means a small error. An old matrix may be far too stiff and make any correction small.
  /// @param settled  the matrix is that of this very iterate, or the residual is as small as rounding can make it:
  ///                 corrections that no longer fall are then rounding. Those of an earlier iterate's matrix may creep,
  ///                 where it is too stiff (a spring that was long, across itself).
  /// @param noise    rounding was measured: no solve can do better than a few roundings
  [[nodiscard]] Judgement judge(int iteration, const Correction& size, bool trusted, bool settled, bool noise = false) {
    const double now = size.relative;
    const bool has_rate = previous_ > 0;
    // Y may pass through zero on its way: progress is measured beside what stands still.
    const double theta = has_rate ? size.beside_all / previous_ : 1;
    if (has_rate && iteration == 2) first_rate_ = theta;
    if (now == 0) {
      // An inexact solve to a tolerance may have done nothing: what is left is at most its share of the target.
      if (rate_ > 0 && trusted && has_rate) rate_ = error_left(std::min(0.5, inexact_share * target_ / previous_), 1);
      return trusted ? Judgement::converged : Judgement::slow;
    }
    previous_ = size.beside_all;
    if (!has_rate) {
      const bool enough = rate_ > 0 ? rate_ * now <= target_ : trusted && target_ == 0 && now <= round_off_;
      return enough ? Judgement::converged : Judgement::go_on;
    }
    // The first correction may be right by luck, in a direction that the matrix's error doesn't see: to rounding, the slower
    // of two successive rates counts.
    const double left = error_left(target_ > 0 ? theta : std::max(theta, last_rate_), now);
    last_rate_ = theta;
    if (rate_ > 0) rate_ = theta < 1 ? error_left(theta, 1) : 1;
    // Where the residual was noise, a few roundings are all that can be had.
    if (left <= (target_ > 0 ? target_ : noise ? 16 * round_off_ : round_off_)) return Judgement::converged;
    if (target_ == 0 && trusted && settled && theta > 0.3 && may_be_rounding(size.beside_all, round_off_))
      return Judgement::converged;
    if (theta > 1) return Judgement::growing;
    if (target_ == 0) return theta > slow_rate ? Judgement::slow : Judgement::go_on;
    const int remaining = limit_ - 1 - (iteration - in_vain_);
    return theta >= 0.99 || left * std::pow(theta, remaining) >= target_ ? Judgement::slow : Judgement::go_on;
  }

 private:
  static constexpr double slow_rate = 0.05;  // to rounding: a new matrix is cheaper than corrections that fall slower
  double round_off_, target_ = 0, previous_ = 0, first_rate_ = 0, last_rate_ = 0;
  double rate_ = 0;  // 0: not known, two corrections at least
  int limit_, in_vain_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
