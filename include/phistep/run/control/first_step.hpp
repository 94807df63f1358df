/// @file
/// A first Δt from what the solution does at the start: an Euler step tells y'' (Hairer, Nørsett & Wanner, Solving ODEs I,
/// sect. II.4, p. 169), and with τ = ‖y'‖/‖y''‖ for the time in which it changes, a step of order p errs by about
///
///     ‖e‖ ≈ ‖y'‖ Δt (Δt/τ)^p.                                                                                   (1)
///
/// Unlike the book's, this rule has the right dimensions: the unit of time changes nothing.
#pragma once

#include <algorithm>
#include <cmath>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/errors/error_norm.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @param slope    slope(t, y, out) → bool: out = y', false where that isn't finite
/// @param length   [time] of the run, with its sign
/// @param order    of the scheme
/// @param allowed  ‖e‖ that a step may have
/// @return |Δt| ≤ |length|; 0 where y' isn't finite at the start. Two force calls.
template <State Plain>
[[nodiscard]] double first_step(auto&& slope, const Plain& y, const ErrorNorm<Plain>& norm, const Plain& weight,
                                ScalarOf<Plain> t, ScalarOf<Plain> length, int order, double allowed) {
  using Scalar = ScalarOf<Plain>;
  const double run = std::abs(static_cast<double>(length));
  Plain f0 = y, f1 = y, probe = y;
  if (!slope(t, y, f0)) return 0;
  const double size = norm(y, weight), speed = norm(f0, weight);
  // The probe moves a hundredth of y, or where y is nothing beside atol, a hundredth of the error allowed.
  double h = speed > 0 ? std::min(run, 0.01 * std::max(size, allowed) / speed) : 1e-6 * run;
  double change = -1;
  for (int tries = 0; tries < 40 && change < 0; ++tries) {
    const Scalar signed_h = static_cast<Scalar>(std::copysign(h, static_cast<double>(length)));
    assign<Plain>(probe, in<Plain>(y) + signed_h * in<Plain>(f0));
    if (slope(t + signed_h, probe, f1)) {
      assign<Plain>(f1, in<Plain>(f1) - in<Plain>(f0));
      change = norm(f1, weight);
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
  const double wanted = speed > 0
                            ? h * std::exp2((std::log2(0.1 * allowed / moved) - p * std::log2(bent / moved)) / (p + 1))
                            : h * std::sqrt(0.1 * allowed / bent);
  return std::min({100 * h, wanted, run});
}

}}  // namespace phistep::PHISTEP_ABI
