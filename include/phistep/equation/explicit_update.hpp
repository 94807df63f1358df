/// @file
/// The two explicit updates of a component, as kernels for the passes of simd/update.hpp:
///
///     kick         v⁺ = v + (h/m) Ψ                                                                             (1)
///     kick, drift  v⁺ = v + (h/m) Ψ,   r⁺ = r + (before v + after v⁺)                                           (2)
#pragma once

#include <type_traits>

#include "phistep/core/version.hpp"
#include "phistep/equation/gamma.hpp"
#include "phistep/simd/update.hpp"

namespace phistep::inline PHISTEP_ABI {

/// (1)
/// @tparam Factor  i ↦ h/m_i
template <class Scalar, class Factor>
struct Kick {
  Input<Scalar> v, psi;
  Factor factor;
  Kick(Input<Scalar> v0, Input<Scalar> f, Factor scale) : v{v0}, psi{f}, factor{scale} {}
  [[gnu::always_inline]] inline void operator()(auto i, auto& v1) const { v1 = v[i] + factor(i) * psi[i]; }
};

/// (2)
template <class Scalar, class Factor, class Before, class After>
struct KickAndDrift {
  Input<Scalar> r, v, psi;
  Factor factor;
  [[no_unique_address]] Before before;  ///< [time]
  [[no_unique_address]] After after;    ///< [time]
  KickAndDrift(Input<Scalar> r0, Input<Scalar> v0, Input<Scalar> f, Factor scale, Before drift_before,
               After drift_after)
      : r{r0}, v{v0}, psi{f}, factor{scale}, before{drift_before}, after{drift_after} {}
  [[gnu::always_inline]] inline void operator()(auto i, auto& v1, auto& r1) const {
    v1 = v[i] + factor(i) * psi[i];
    if constexpr (std::is_same_v<After, Zero>) r1 = r[i] + before * v[i];
    else if constexpr (std::is_same_v<Before, Zero>) r1 = r[i] + after * v1;
    else r1 = r[i] + (before * v[i] + after * v1);
  }
};
}  // namespace phistep::inline PHISTEP_ABI
