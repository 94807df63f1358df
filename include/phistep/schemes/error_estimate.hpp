/// @file
/// What the slopes of this step and the last tell: where the solution will be, and how far a step of order 2 is off.
#pragma once

#include <type_traits>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Where the step before is known, the next resolve starts from y(t + h) on the parabola through y, y' and the slope before
/// (Adams-Bashforth of order 2 at h = Δt).
template <class Step, class Scalar>
void predict(Step& step, Scalar h) {
  if constexpr (Step::is_traced) {
    using Plain = std::remove_cvref_t<decltype(step.next)>;
    auto& trace = step.trace;
    if (trace.dt_before == 0) return;
    const auto y = in<Plain>(step.y), start = in<Plain>(trace.start), before = in<Plain>(trace.before);
    assign<Plain>(trace.predicted, y + h * start + (h * h / (2 * trace.dt_before)) * (start - before));
    step.has_prediction = true;
  }
}
/// Δt³/12 y‴, the trapezoidal rule's y⁺ − y(t+Δt), times a factor, as an expression. y‴ is the second difference of three
/// slopes.
template <State Plain>
[[nodiscard]] auto milne(const Trace<Plain>& trace, ScalarOf<Plain> dt, ScalarOf<Plain> factor = 1) {
  const auto end = in<Plain>(trace.end), start = in<Plain>(trace.start), before = in<Plain>(trace.before);
  const auto rho = dt / trace.dt_before;
  return factor * dt / (6 * (1 + 1 / rho)) * ((end - start) - rho * (start - before));
}

}}  // namespace phistep::PHISTEP_ABI
