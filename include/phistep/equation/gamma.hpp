/// @file
/// The coefficients by which a step weighs Ψ and v.
#pragma once

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The coefficients of a resolve: γ on the force and γ on the drift. [time]
template <class Scalar>
struct Gamma {
  Scalar force;
  Scalar drift;
  friend bool operator==(const Gamma&, const Gamma&) = default;
};

/// Coefficients of out = y + γ M⁻¹Ψ, and for motion r⁺ = r + before·v + after·v⁺.
template <class Scalar>
struct Advance {
  Scalar kick;    ///< γ on M⁻¹Ψ
  Scalar before;  ///< on the velocity that the step starts from
  Scalar after;   ///< on the velocity just computed
};

}  // namespace phistep::inline PHISTEP_ABI
