/// @file
/// The times of the steps that one call of a stepper does: one step, or several of one length.
#pragma once

#include <cstdint>

#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Scalar>
struct OneStep {
  Scalar start, dt;  ///< [time]
  [[nodiscard]] static constexpr std::int64_t count() { return 1; }
  [[nodiscard]] Scalar t(std::int64_t) const { return start; }
};

/// Steps from node to node of a grid t₀ + nΔt, none of them its last: their lengths and times are known to be sound.
template <class Scalar>
struct GridSteps {
  Scalar t0, dt;              ///< [time]
  std::int64_t first, steps;  ///< the node where the first begins; how many there are
  [[nodiscard]] std::int64_t count() const { return steps; }
  [[nodiscard]] Scalar t(std::int64_t n) const { return t0 + static_cast<Scalar>(first + n) * dt; }
};

}}  // namespace phistep::PHISTEP_ABI
