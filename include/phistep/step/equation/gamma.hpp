/// @file
/// The coefficients by which a step weighs Ψ and v.
#pragma once

#include <cmath>
#include <type_traits>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The coefficients of a resolve: γ on the force and γ on the drift. [time]
template <class Scalar>
struct Gamma {
  Scalar force;  ///< γ_f, on Ψ
  Scalar drift;  ///< γ_d, on a motion's v
  friend bool operator==(const Gamma&, const Gamma&) = default;
};

/// By what corrections with factors made for γ_p are multiplied so that they serve γ: 2/(1 + γ/γ_p), with (γ/γ_p)² where W has
/// γ_f γ_d alone (A. C. Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005) 363, sect. 2.1). 0: they don't serve, being
/// further apart than `within`, or other ones of force and drift.
template <class Scalar>
[[nodiscard]] Scalar correction_scale(const Gamma<Scalar>& gamma, const Gamma<Scalar>& made_for, Scalar within,
                                      bool is_square) {
  const Scalar ratio = gamma.force / made_for.force;
  const bool is_similar = gamma.drift * made_for.force == gamma.force * made_for.drift;
  if (!(std::abs(ratio - 1) <= within) || !is_similar) return Scalar{0};
  return 2 / (1 + (is_square ? ratio * ratio : ratio));
}

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

}}  // namespace phistep::PHISTEP_ABI
