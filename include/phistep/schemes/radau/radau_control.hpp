/// @file
/// What a Radau run decides between its steps: how long the next one is, of how many stages, and when an iteration has
/// done enough (Hairer & Wanner, Solving ODEs II, sect. IV.8; J. Comput. Appl. Math. 111 (1999) 93).
///
/// The estimate of s stages goes as h^{s+1}, the error at the end of a run as h^{2s−1} where nothing is stiff, and as h^s or
/// so in stiff components. For the former to go as rtol, the estimate, weighted by 1/(atol + rtol |y|), would be held to
/// rtol^{(s+1)/(2s−1) − 1}, for the latter to 1: it is held to their geometric mean. At equal error that is as fast as the
/// former, whose errors jump by factors of 100 from tolerance to tolerance (Oregonator, HIRES), here by 10. But never to
/// more than 16: what stiff components owe to their last step alone is then off by as much (Prothero-Robinson, up to three
/// times that), and beyond 100 it would be a wrong answer called a success.
#pragma once

#include <algorithm>
#include <cmath>

#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/step/solve/convergence.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The judge of one solve by simplified Newton iteration, by the sizes of its corrections.
class RadauIteration {
 public:
  /// @param target  the size of the error that may be left; round_off: all but rounding, where corrections stop falling
  /// @param rate    θ/(1−θ) as the solve before left it
  RadauIteration(double target, double rate, int limit, double round_off)
      : target_{target}, rate_{aged(std::max(rate, 1e-5))}, round_off_{round_off}, limit_{limit} {}

  /// @param share  of what is corrected in all whose rounding reaches it
  [[nodiscard]] Judgement judge(double size, double share = 1) {
    ++count_;
    if (!std::isfinite(size)) return failed();
    if (count_ > 1) {
      const bool to_rounding = target_ <= round_off_;
      const double now = size / size_;
      contraction_ = count_ == 2 || to_rounding ? now : std::max(now, std::sqrt(now * last_));
      last_ = now;
      if (now > 0.3 && may_be_rounding(share * size, round_off_)) return Judgement::converged;
      if (size > 0 && (to_rounding ? count_ > 3 && now > 2 : contraction_ >= 0.99)) return failed();
      rate_ = error_left(contraction_, 1);
      const int left = limit_ - 1 - count_;
      const double at_end = rate_ * size * power(contraction_, left) / target_;
      if (!to_rounding && left >= 0 && at_end >= 1) {
        shrink_ = 0.8 * std::pow(std::min(at_end, 20.0), -1.0 / (4 + left));
        return failed();
      }
    }
    size_ = size;
    if (rate_ * size <= target_) return Judgement::converged;
    return count_ < limit_ ? Judgement::go_on : failed();
  }
  /// A correction that the next can't be compared with.
  [[nodiscard]] Judgement begin_again() {
    count_ = 0;
    return ++beginnings_ < limit_ ? Judgement::go_on : failed();
  }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] int limit() const { return limit_; }
  /// θ of the corrections seen, 0 after the first
  [[nodiscard]] double contraction() const { return contraction_; }
  [[nodiscard]] double rate() const { return rate_; }
  /// The next try's length, relative to this one's.
  [[nodiscard]] double shrink() const { return shrink_; }

 private:
  [[nodiscard]] Judgement failed() const { return contraction_ > 1 ? Judgement::growing : Judgement::slow; }
  /// x^¾: an old rate counts less and less. HW II p. 121 has x^0.8, which takes longer to compute.
  [[nodiscard]] static double aged(double x) { return std::sqrt(x * std::sqrt(x)); }

  double target_, rate_, round_off_;
  int limit_, count_ = 0, beginnings_ = 0;
  double size_ = 0, last_ = 0, contraction_ = 0, shrink_ = 0.5;
};

/// Length and stages from step to step.
class RadauControl {
 public:
  /// @param stages  0: chosen
  explicit RadauControl(int stages) : wanted_{stages} {}

  /// A step is to be tried. @param is_first  what was known of the steps before doesn't hold
  void begin(double rtol, bool is_first) {
    if (is_first) forget();
    if (rtol_ != rtol || stages_ == 0) {
      rtol_ = rtol;
      choose(wanted_ != 0 ? wanted_ : rtol > 2e-3 ? 3 : rtol > 3e-6 ? 5 : 7);
    }
  }
  [[nodiscard]] int stages() const { return stages_; }
  /// ‖e‖ that a step may have, in units of the tolerance
  [[nodiscard]] double allowed() const { return allowed_; }
  /// A part of rtol may be left. It is small, because where θ is not one number the slowest part of the error is larger than
  /// the sizes of corrections say, and is what the result then suffers from; an iteration more costs less than it gains.
  [[nodiscard]] RadauIteration iteration(double round_off) const {
    const double share = stages_ == 3 ? 0.01 : 0.001;
    return {std::max(share, 10 * round_off / rtol_), rate_, stages_ == 3 ? 7 : stages_ == 5 ? 12 : 17, round_off};
  }

  /// Whether the iteration's Jacobian may serve the next step, too: where its contraction θ is 0.03 or less. Hairer & Wanner,
  /// Solving ODEs II, p. 121, ask for 0.001; above 0.03 an old Jacobian costs more iterations than a new one costs force calls.
  [[nodiscard]] static bool is_fast(const RadauIteration& solve) { return solve.contraction() <= 0.03; }
  /// The |Δt| to propose after a step whose error is `error` tolerances. Sets `success`: whether that error is allowed.
  /// @param keeps  the Jacobian is kept: where Δt would grow by a factor of at most 1.2 it stays, and so do the factors
  [[nodiscard]] double after(double dt, double error, const RadauIteration& solve, bool keeps, bool& success) {
    rate_ = solve.rate();
    failures_ = 0;
    const double relative = error / allowed_;
    const double n = 2 * solve.limit();
    const double safety = std::min(0.9, 0.9 * (1 + n) / (solve.count() + n));
    double by = limited(safety / root(relative));
    success = relative < 1;
    if (!success) {
      rejected_ = true;
      return (dt_before_ == 0 ? 0.1 : by) * dt;
    }
    // Gustafsson's predictive controller: HW II, eq. IV.8.26.
    if (dt_before_ > 0)
      by = std::min(by, limited(safety_factor * dt / (dt_before_ * root(relative * relative / error_before_))));
    // An iteration that contracts by θ, about in proportion to Δt, costs 1/ln(1/θ): faster ones pay for more steps.
    if (solve.contraction() > best_contraction)
      by = std::min(by, std::max(0.5, best_contraction / solve.contraction()));
    dt_before_ = dt;
    error_before_ = std::max(1e-2, relative);
    if (rejected_) by = std::min(by, 1.0);
    rejected_ = false;
    if (keeps && by >= 1 && by <= 1.2) by = 1;  // loc. cit., p. 124
    return by * dt;
  }
  /// The next Δt after a step whose equations weren't solved.
  [[nodiscard]] double failed(double dt, double shrink) {
    rejected_ = true;
    rate_ = 1;
    return (++failures_ > 4 ? 0.1 : shrink) * dt;  // a rate that rises by ten decades takes as many
  }
  void forget() {
    dt_before_ = 0;
    error_before_ = rate_ = 1;
    rejected_ = false;
    failures_ = 0;
  }
  void archive(auto& ar) {
    ar("stages", stages_, "rtol", rtol_, "allowed", allowed_, "dt_before", dt_before_, "error_before", error_before_,
       "rate", rate_, "rejected", rejected_);
    ar.check(stages_ == 0 || stages_ == 3 || stages_ == 5 || stages_ == 7);
  }

 private:
  static constexpr double safety_factor = 0.9, best_contraction = 0.2;

  /// x^{1/(s+1)}
  [[nodiscard]] double root(double x) const {
    const double half = std::sqrt(x);
    return stages_ == 3 ? std::sqrt(half) : stages_ == 5 ? std::cbrt(half) : std::sqrt(std::sqrt(half));
  }
  [[nodiscard]] static double limited(double by) { return std::clamp(by, 0.2, 8.0); }
  void choose(int stages) {
    stages_ = stages;
    const double mean = std::pow(rtol_, 0.5 * static_cast<double>(2 - stages) / static_cast<double>(2 * stages - 1));
    allowed_ = std::min(mean, 16.0);
    dt_before_ = 0;
  }

  int wanted_, stages_ = 0;
  double rtol_ = 0, allowed_ = 1;
  double dt_before_ = 0, error_before_ = 1, rate_ = 1;
  bool rejected_ = false;
  int failures_ = 0;  // of the tries of this step
};

}}  // namespace phistep::PHISTEP_ABI
