/// @file
/// How far a step of order 2 is off, by the slopes of this step and the last.
#pragma once

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Δt³/12 y‴, the trapezoidal rule's y⁺ − y(t+Δt), times a factor, as an expression. y‴ is the second difference of three
/// slopes.
template <State Plain>
[[nodiscard]] auto milne(const Trace<Plain>& trace, ScalarOf<Plain> dt, ScalarOf<Plain> factor = 1) {
  const auto end = in<Plain>(trace.end), start = in<Plain>(trace.start), before = in<Plain>(trace.before);
  const auto rho = dt / trace.dt_before;
  return factor * dt / (6 * (1 + 1 / rho)) * ((end - start) - rho * (start - before));
}

}}  // namespace phistep::PHISTEP_ABI
