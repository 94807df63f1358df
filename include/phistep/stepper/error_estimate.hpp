/// @file
/// What the slopes of this step and the last tell: where the solution will be, and how far a step of order 2 is off.
#pragma once

#include "phistep/control/trace.hpp"
#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// trace.predicted = y(t + h) by the parabola through y, y' and the slope before (Adams-Bashforth of order 2 at h = Δt).
template <State Plain>
void predict(Trace<Plain>& trace, const Plain& y, ScalarOf<Plain> h) {
  const auto curvature = h * h / (2 * trace.dt_before);
  for_each_block([h, curvature](auto, auto& to, const auto& from, const auto& start,
                                const auto& before) { to = from + h * start + curvature * (start - before); },
                 Blocks<Plain>::all(trace.predicted), Blocks<Plain>::all(y), Blocks<Plain>::all(trace.start),
                 Blocks<Plain>::all(trace.before));
}
/// trace.error = −Δt³/12 y‴ of the trapezoidal rule, y‴ by the second difference of three slopes.
template <State Plain>
void milne(Trace<Plain>& trace, ScalarOf<Plain> dt) {
  const auto rho = dt / trace.dt_before, by = dt / (6 * (1 + 1 / rho));
  for_each_block([rho, by](auto, auto& e, const auto& end, const auto& start,
                           const auto& before) { e = by * ((end - start) - rho * (start - before)); },
                 Blocks<Plain>::all(trace.error), Blocks<Plain>::all(trace.end), Blocks<Plain>::all(trace.start),
                 Blocks<Plain>::all(trace.before));
}

}  // namespace phistep::inline PHISTEP_ABI
