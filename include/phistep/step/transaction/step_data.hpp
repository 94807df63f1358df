/// @file
/// What a scheme works with during one step.
#pragma once

#include "phistep/base/version.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a scheme works with during one step.
template <class Plain, class Rate, class Scalar, class Masses>
struct StepData {
  const Plain& y;   ///< the state at t
  const Scalar t;   ///< [time]
  const Scalar dt;  ///< [time]
  Plain& next;      ///< becomes the state at t + Δt
  Rate& psi;        ///< holds Ψ(t, y) if `psi_known`, else scratch
  const Masses& masses;
  bool psi_known;
  bool psi_next_known = false;   ///< the scheme leaves Ψ(t+Δt, next) in psi
  bool psi_carried = psi_known;  ///< it comes from the step before, to what that has solved
  bool is_state_next = false;    ///< the state is what next would be, nothing is left to commit
  static constexpr bool is_traced = false;
  /// A part of this step, from `from` to `to`.
  [[nodiscard]] StepData part(const Plain& from, Scalar t0, Scalar length, Plain& to, bool knows_psi) const {
    return {from, t0, length, to, psi, masses, knows_psi};
  }
};
/// … of a step whose slopes and error a controller or dense output reads.
template <class Plain, class Rate, class Scalar, class Masses>
struct TracedStepData : StepData<Plain, Rate, Scalar, Masses> {
  Trace<Plain>& trace;
  bool has_prediction = false;  ///< trace.predicted is where the next resolve starts
  static constexpr bool is_traced = true;
};

}}  // namespace phistep::PHISTEP_ABI
