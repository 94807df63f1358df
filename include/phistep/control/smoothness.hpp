/// @file
/// Whether the force is smooth over a step, by the estimates of the tries before it: ‖e‖ of a smooth one goes as Δt^k, that of
/// one with a jump inside as Δt at most. An estimate may miss the jump, because its weights cancel at the stages before it;
/// that it has not fallen since the last try as Δt^k does is seen wherever the jump is.
#pragma once

#include <cmath>

#include "phistep/core/arithmetic.hpp"
#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The estimates of the tries of a run.
class Smoothness {
 public:
  /// False where ‖e‖ has grown too much beyond Δt^k since the last smooth try.
  /// @param square  of ‖e‖   @param dt  [time] Δt   @param k  the power of Δt in ‖e‖
  [[nodiscard]] bool holds(double square, double dt, int k) {
    now_ = {square, std::abs(dt)};
    // Steps that follow each other may meet a force that changes fast; those that start from one point meet the same.
    const double most = is_retry_ ? 8 : 300;
    const double allowed = before_.square * most * most;
    const bool smooth = !(before_.square > 0) || (square <= allowed && now_.dt >= before_.dt) ||
                        square <= allowed * power_of(now_.dt / before_.dt, 2 * k);
    if (smooth) before_ = now_;
    is_retry_ = true;
    return smooth;
  }
  /// The last try has become a step.
  void accepted() {
    before_ = now_;
    is_retry_ = false;
  }
  void forget() { *this = {}; }
  void archive(auto& ar) {
    ar("square", now_.square, "dt", now_.dt);
    ar.check(now_.square >= 0 && now_.dt >= 0);
    before_ = now_;
  }

 private:
  struct Try {
    double square = 0;  ///< of ‖e‖; 0: nothing is known
    double dt = 0;      ///< [time]
  };
  Try before_, now_;
  bool is_retry_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
