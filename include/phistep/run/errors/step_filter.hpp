/// @file
/// The next step's length from the errors of the last ones: digital filters of G. Söderlind, ACM Trans. Math. Softw. 29
/// (2003) 1, table III; with ε = 1/‖e‖ (relative to what is allowed) and k the order of e in Δt,
///
///     ρ_n = ε_n^{β₁/k} ε_{n−1}^{β₂/k} ρ_{n−1}^{−α₂},     Δt_{n+1} = ρ Δt_n.                                     (1)
///
/// Limited smoothly by 1 + atan(ρ − 1) (G. Söderlind & L. Wang, J. Comput. Appl. Math. 185 (2006) 225), which never
/// exceeds 2.57; or, where errors change by decades from step to step as in stiff problems, with the trend of the last
/// two carried on (K. Gustafsson, ACM Trans. Math. Softw. 20 (1994) 496; Hairer & Wanner, Solving ODEs II, eq. IV.8.25),
///
///     Δt_{n+1} = 0.9 Δt_n ε_n^{1/k} min(1, Δt_n/Δt_{n−1} (ε_n/ε_{n−1})^{1/k}).                                 (2)
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "phistep/base/facts/scheme_facts.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// log₂ x and 2^x to 3e-7 of what they are: more than a step length needs, and short, inline and the same on every machine.

/// log₂ x of a finite normal x > 0: that of its power of two, and a polynomial for what is left, between √½ and √2.
[[nodiscard, gnu::always_inline]] inline double short_log2(double x) {
  constexpr std::uint64_t root_of_half = 0x3fe6a09e667f3bcd;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const std::int64_t power = static_cast<std::int64_t>(bits - root_of_half) >> 52;
  const double t = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(power) << 52)) - 1, s = t * t;
  const double low =
      (1.44269499489304656 - 0.721352931362974142 * t) + s * (0.48091670800022001 - 0.360225182460989429 * t);
  const double high =
      (0.287288882373974613 - 0.249271822074913675 * t) + s * (0.232652578821136235 - 0.142759734359919774 * t);
  return static_cast<double>(power) + t * (low + s * s * high);
}
/// 2^x for |x| < 1000: 2 to the nearest integer, and a polynomial for what is left.
[[nodiscard, gnu::always_inline]] inline double short_exp2(double x) {
  constexpr double integers = 6755399441055744;  // 1.5·2⁵²: numbers beside it have no fraction
  const double rounded = x + integers, t = x - (rounded - integers), s = t * t;
  const double low =
      (0.693147180559945309 + 0.240223490380203614 * t) + s * (0.0555038101379645743 + 0.00966636851538544831 * t);
  const double fraction = 1 + t * (low + s * s * 0.00133813025373207962);
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(fraction) + (std::bit_cast<std::uint64_t>(rounded) << 52));
}

/// How Δt follows the errors of the last steps.
enum class StepFilter : std::uint8_t {
  automatic,  ///< PI42 with a dead band where Δt costs a factorization, predictive where each step does, H211b elsewhere
  PI42,       ///< proportional-integral: calm, for implicit steps
  H211b,      ///< smoothest steps, with b = 4
  predictive  ///< (2): sees a boundary layer coming
};

/// The controller's memory.
class StepSize {
 public:
  /// @param order_of_error  k
  /// @param dead_band       a growth by less than this keeps Δt, and with it the factorized matrix; 1: none
  StepSize(StepFilter filter, int order_of_error, double dead_band) { obey(filter, order_of_error, dead_band); }
  StepSize() : StepSize{StepFilter::PI42, 1, 1} {}
  /// The same for the steps to come; what is known of those before stays.
  void obey(StepFilter filter, int order_of_error, double dead_band) {
    filter_ = filter;
    weights_ = filter == StepFilter::H211b ? Weights{1.0 / 4, 1.0 / 4, 1.0 / 4} : Weights{3.0 / 5, -1.0 / 5, 0};
    per_k_ = 1.0 / order_of_error;
    dead_band_ = dead_band > 1 ? std::log2(dead_band) : 0;
  }

  /// ρ after a step that was accepted with ‖e‖² ≤ 1.
  [[nodiscard, gnu::always_inline]] inline double accepted_square(double square) {
    return filter_ == StepFilter::predictive ? predicted(square) : accepted(std::sqrt(square));
  }
  /// ρ after a step that was accepted with ‖e‖ ≤ 1.
  [[nodiscard]] double accepted(double error) {
    if (filter_ == StepFilter::predictive) return predicted(error * error);
    // In logarithms, (1) is a sum: one of them and one exponential in place of five powers, and often not even that.
    const double now = -std::log2(std::max(error, smallest) * (1 / safety)) * per_k_;
    const double grown = seen_ ? weights_.now * now + weights_.before * past_ - weights_.ratio * ratio_ : now;
    past_ = now;
    seen_ = true;
    double ratio = 1;
    if (dead_band_ == 0) ratio = limited(grown);
    // Where a new length costs, it has to be worth it, and then to last.
    else if (grown < 0) ratio = std::min(limited(grown), 0.9);
    else if (now >= dead_band_) ratio = std::min(std::exp2(now), 5.0);
    // Right after a rejection the error estimate is an optimist.
    if (rejected_) ratio = std::min(ratio, 1.0);
    rejected_ = false;
    ratio = std::max(ratio, 0.2);
    if (weights_.ratio != 0) ratio_ = std::log2(ratio);
    return ratio;
  }
  /// ρ after a step that was rejected with ‖e‖ > 1.
  [[nodiscard]] double rejected(double error) {
    const double ratio = std::clamp(std::isfinite(error) ? std::pow(safety / error, per_k_) : 0.2, 0.2, 0.9);
    if (filter_ == StepFilter::predictive)
      ratio_ += std::log2(ratio);  // the last accepted step is still the one to compare with
    else forget();
    rejected_ = true;
    return ratio;
  }
  /// Something else than (1) ruled the last Δt.
  void forget() {
    seen_ = false;
    ratio_ = 0;
  }

  void archive(auto& ar) {
    ar("past", past_, "ratio", ratio_, "seen", seen_, "rejected", rejected_);
    ar.check(std::isfinite(past_) && std::isfinite(ratio_));
  }

 private:
  static constexpr double safety = 0.8;      ///< on the error: aim below what is allowed
  static constexpr double smallest = 1e-10;  ///< an error this small is none

  static constexpr double log2_of_fifth = -2.321928094887362;

  /// (2) in logarithms, with past_ that of the root of the last accepted ‖e‖ and ratio_ that of what Δt was multiplied by since
  [[nodiscard, gnu::always_inline]] inline double predicted(double square) {
    constexpr double log2_of_09 = -0.15200309344504997, log2_of_6 = 2.584962500721156,
                     log2_of_hundredth = -6.643856189774724;
    const double now = short_log2(std::max(square, smallest * smallest)) * (per_k_ / 2);
    const double change = ratio_ + past_ - now,
                 trend = seen_ ? (change - std::abs(change)) / 2 : 0;  // no larger than 0
    ratio_ = std::clamp(log2_of_09 - now + trend, log2_of_fifth, rejected_ ? 0.0 : log2_of_6);
    rejected_ = false;
    past_ = std::max(now, log2_of_hundredth * per_k_);  // one lucky step makes no trend
    seen_ = true;
    return short_exp2(ratio_);
  }
  struct Weights {
    double now, before, ratio;  ///< β₁, β₂, α₂
  };
  [[nodiscard]] static double limited(double growth) { return 1 + std::atan(std::exp2(growth) - 1); }

  StepFilter filter_{};
  Weights weights_{};
  double per_k_ = 1, dead_band_ = 0;  ///< 1/k; log₂ of the dead band
  double past_ = 0;                   ///< log₂ ε_{n−1}^{1/k}; (2): its negative
  double ratio_ = 0;                  ///< log₂ ρ_{n−1}
  bool seen_ = false, rejected_ = false;
};

/// How the error of a scheme's steps goes with their length, and what a new length costs.
struct ErrorLaw {
  int order = 1;                          ///< of the scheme
  int error_order = 2;                    ///< the power of Δt with which its estimate goes
  double dead_band = 1;                   ///< see StepSize; more than 1 where a kept Δt spares a factorization
  bool reads_weights = true;              ///< steps read trace.weight
  StepFilter filter = StepFilter::H211b;  ///< the one that suits, unless the user names another
  bool looks_for_jumps = false;           ///< its estimate falls as that power, or the force isn't smooth (Smoothness)
  bool damps = false;                     ///< it is implicit: no step makes more of an error than it was
};

template <class Stepper>
[[nodiscard]] ErrorLaw error_law(const Stepper& stepper) {
  ErrorLaw law{.order = stepper.order(),
               .error_order = stepper.order() + 1,
               .reads_weights = facts_of<Stepper>.reads_weights,
               .damps = !facts_of<Stepper>.solves_nothing};
  if constexpr (requires { stepper.working().error_order(); }) law.error_order = stepper.working().error_order();
  bool keeps_factors = !facts_of<Stepper>.refactorizes;
  if constexpr (requires { StepperInternals::kernel(stepper); })
    keeps_factors = keeps_factors && StepperInternals::kernel(stepper).keeps_factors();
  // Newton makes do with old factors within limits; an affine step can't, and new ones are most of what it costs.
  if (keeps_factors) law.dead_band = facts_of<Stepper>.is_affine ? 2 : 1.2;
  if constexpr (facts_of<Stepper>.refactorizes) law.filter = StepFilter::predictive;
  else if (law.dead_band > 1) law.filter = StepFilter::PI42;
  else if (law.order >= 5) {
    law.filter = StepFilter::predictive;                     // where Δt changes by a fifth, errors do by a decade
    law.looks_for_jumps = !facts_of<Stepper>.reads_weights;  // those with estimates of their own do it themselves
  }
  return law;
}

}}  // namespace phistep::PHISTEP_ABI
