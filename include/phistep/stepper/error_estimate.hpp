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
/// Δt³/12 y‴, the trapezoidal rule's y⁺ − y(t+Δt), times a factor: f(e, that), block by block. y‴ is the second difference of
/// three slopes.
template <State Plain>
void with_milne(Trace<Plain>& trace, ScalarOf<Plain> dt, ScalarOf<Plain> factor, auto&& f) {
  const auto rho = dt / trace.dt_before, by = factor * dt / (6 * (1 + 1 / rho));
  for_each_block([&](auto, auto& e, const auto& end, const auto& start,
                     const auto& before) { f(e, by * ((end - start) - rho * (start - before))); },
                 Blocks<Plain>::all(trace.error), Blocks<Plain>::all(trace.end), Blocks<Plain>::all(trace.start),
                 Blocks<Plain>::all(trace.before));
}
/// trace.error = that
template <State Plain>
void set_milne(Trace<Plain>& trace, ScalarOf<Plain> dt) {
  with_milne(trace, dt, ScalarOf<Plain>{1}, [](auto& e, const auto& x) { e = x; });
}
/// trace.error += factor · that
template <State Plain>
void add_milne(Trace<Plain>& trace, ScalarOf<Plain> dt, ScalarOf<Plain> factor) {
  with_milne(trace, dt, factor, [](auto& e, const auto& x) { e += x; });
}

}  // namespace phistep::inline PHISTEP_ABI
