/// @file
/// The next step's length from the errors of the last ones: digital filters of G. Söderlind, ACM Trans. Math. Softw. 29
/// (2003) 1, table III; with ε = 1/‖e‖ (relative to what is allowed) and k the order of e in Δt,
///
///     ρ_n = ε_n^{β₁/k} ε_{n−1}^{β₂/k} ε_{n−2}^{β₃/k} ρ_{n−1}^{−α₂},     Δt_{n+1} = ρ Δt_n.                       (1)
///
/// Limited smoothly by 1 + atan(ρ − 1) (G. Söderlind & L. Wang, J. Comput. Appl. Math. 185 (2006) 225), which never
/// exceeds 2.57; or, where errors change by decades from step to step as in stiff problems, with the trend of the last
/// two carried on (K. Gustafsson, ACM Trans. Math. Softw. 20 (1994) 496; Hairer & Wanner, Solving ODEs II, eq. IV.8.25),
///
///     Δt_{n+1} = 0.9 Δt_n ε_n^{1/k} min(1, Δt_n/Δt_{n−1} (ε_n/ε_{n−1})^{1/k}).                                 (2)
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Which filter.
enum class StepFilter : std::uint8_t {
  automatic,   ///< PI42 with a dead band where Δt costs a factorisation, predictive where each step does, H211b elsewhere
  elementary,  ///< ρ = ε^{1/k}: reacts to everything
  PI42,        ///< proportional-integral: calm, for implicit steps
  H211b,       ///< smoothest steps, with b = 4
  H312PID,     ///< of third order
  predictive,  ///< (2): sees a boundary layer coming
};

/// The controller's memory.
class StepSize {
 public:
  /// @param order_of_error  k
  /// @param dead_band       a growth by less than this keeps Δt, and with it the factorised matrix; 1: none
  StepSize(StepFilter filter, int order_of_error, double dead_band)
      : filter_{filter}, weights_{weights(filter)}, k_{static_cast<double>(order_of_error)}, dead_band_{dead_band} {}
  StepSize() : StepSize{StepFilter::elementary, 1, 1} {}

  /// ρ after a step that was accepted with ‖e‖ ≤ 1.
  [[nodiscard]] double accepted(double error) {
    if (filter_ == StepFilter::predictive) return predicted(error);
    past_ = {std::pow(safety / std::max(error, smallest), 1 / k_), past_[0], past_[1]};
    seen_ = std::min(seen_ + 1, 3);
    const Weights w = seen_ < weights_.reach ? weights(StepFilter::elementary) : weights_;
    double ratio = std::pow(past_[0], w.beta[0]) * std::pow(past_[1], w.beta[1]) * std::pow(past_[2], w.beta[2]) *
                   std::pow(ratio_, -w.alpha);
    ratio = 1 + std::atan(ratio - 1);
    // Where a new length costs, it has to be worth it, and then to last.
    if (dead_band_ > 1) ratio = ratio < 1 ? std::min(ratio, 0.9) : past_[0] < dead_band_ ? 1 : std::min(past_[0], 5.0);
    // Right after a rejection the error estimate is an optimist.
    if (rejected_) ratio = std::min(ratio, 1.0);
    rejected_ = false;
    return ratio_ = std::max(ratio, 0.2);
  }
  /// ρ after a step that was rejected with ‖e‖ > 1.
  [[nodiscard]] double rejected(double error) {
    const double ratio = std::clamp(std::isfinite(error) ? std::pow(safety / error, 1 / k_) : 0.2, 0.2, 0.9);
    if (filter_ == StepFilter::predictive) ratio_ *= ratio;  // the last accepted step is still the one to compare with
    else forget();
    rejected_ = true;
    return ratio;
  }
  /// Something else than (1) ruled the last Δt.
  void forget() {
    seen_ = 0;
    ratio_ = 1;
  }

  void archive(auto& ar) { ar(past_, ratio_, seen_, rejected_); }

 private:
  static constexpr double safety = 0.8;      ///< on the error: aim below what is allowed
  static constexpr double smallest = 1e-10;  ///< an error this small is none

  /// (2), with past_[0] the last accepted ‖e‖ and ratio_ what Δt was multiplied by since
  [[nodiscard]] double predicted(double error) {
    double ratio = std::pow(std::max(error, smallest), -1 / k_);
    if (seen_ > 0) ratio *= std::min(1.0, ratio_ * std::pow(past_[0] / std::max(error, smallest), 1 / k_));
    ratio = std::clamp(0.9 * ratio, 0.2, 6.0);
    if (rejected_) ratio = std::min(ratio, 1.0);
    rejected_ = false;
    past_[0] = std::max(error, 0.01);  // one lucky step makes no trend
    seen_ = 1;
    return ratio_ = ratio;
  }

  struct Weights {
    std::array<double, 3> beta;
    double alpha;
    int reach;  ///< how many errors it needs
  };
  [[nodiscard]] static Weights weights(StepFilter filter) {
    switch (filter) {
      case StepFilter::PI42:
        return {{3.0 / 5, -1.0 / 5, 0}, 0, 2};
      case StepFilter::H211b:
        return {{1.0 / 4, 1.0 / 4, 0}, 1.0 / 4, 2};
      case StepFilter::H312PID:
        return {{1.0 / 18, 2.0 / 18, 1.0 / 18}, 0, 3};
      default:
        return {{1, 0, 0}, 0, 1};
    }
  }

  StepFilter filter_;
  Weights weights_;
  double k_, dead_band_;
  std::array<double, 3> past_{1, 1, 1};  ///< ε^{1/k}, the newest first
  double ratio_ = 1;
  int seen_ = 0;
  bool rejected_ = false;
};

}  // namespace phistep::inline PHISTEP_ABI
