/// @file
/// How stiff a problem is along its solution: what a pilot of coarse implicit steps meets on its way, against the rate
/// ρ = |λ|max of ∂y'/∂y at each of them. An explicit scheme bears about ρΔt ≤ 3 a step, whatever its order, so that it needs
/// ∫ρ dt / 3 steps; where that is many times what the pilot needs, the problem is stiff. Looking at the start alone would miss
/// what becomes stiff after a transient (Robertson's reaction: ρ = 0.04 at t = 0, 2400 a moment later).
#pragma once

#include <algorithm>
#include <cmath>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// What a pilot found.
struct Stiffness {
  double rate = 0;          ///< largest |λ| met [1/time]
  double turns = 0;         ///< ∫ρ dt over the whole span, extrapolated where the pilot didn't reach its end
  double steps = 0;         ///< the pilot's steps over the whole span, likewise
  double covered = 0;       ///< share of the span that it saw
  double tolerance = 1e-2;  ///< relative, of its steps
  bool known = false;

  /// Steps of an explicit scheme for each of an implicit one, both at the pilot's accuracy: 1 where nothing is stiff.
  [[nodiscard]] double ratio() const { return steps > 0 ? std::max(1.0, turns / 3 / steps) : 1; }
};

}  // namespace phistep::inline PHISTEP_ABI
