/// @file
/// The coefficients by which a step weighs Ψ and v.
#pragma once

#include <type_traits>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The coefficients of a resolve: γ on the force and γ on the drift. [time]
template <class Scalar>
struct Gamma {
  Scalar force;  ///< γ_f, on Ψ
  Scalar drift;  ///< γ_d, on a motion's v
  friend bool operator==(const Gamma&, const Gamma&) = default;
};

/// A coefficient that is 0 for every Δt: its term is left out. 0·v⁺ would make r⁺ wait for v⁺.
using Zero = std::integral_constant<int, 0>;
/// h, or Zero where that is known when compiling
template <bool is_zero, class Scalar>
[[nodiscard]] constexpr auto unless(Scalar h) {
  if constexpr (is_zero) return Zero{};
  else return h;
}

/// Coefficients of out = y + γ M⁻¹Ψ, and for motion r⁺ = r + before·v + after·v⁺. [time]
template <class Scalar, class Before = Scalar, class After = Scalar>
struct Advance {
  Scalar kick;    ///< γ on M⁻¹Ψ
  Before before;  ///< on the velocity that the step starts from
  After after;    ///< on the velocity just computed
  operator Advance<Scalar>() const requires(!std::is_same_v<Advance, Advance<Scalar>>) {
    return {kick, static_cast<Scalar>(before), static_cast<Scalar>(after)};
  }
};
template <class Scalar, class Before, class After>
Advance(Scalar, Before, After) -> Advance<Scalar, Before, After>;

}  // namespace phistep::inline PHISTEP_ABI
