/// @file
/// The two explicit updates of a component, as kernels for the passes of simd/update.hpp:
///
///     kick         v⁺ = v + (h/m) Ψ                                                                             (1)
///     kick, drift  v⁺ = v + (h/m) Ψ,   r⁺ = r + (before v + after v⁺)                                           (2)
#pragma once

#include "phistep/core/version.hpp"
#include "phistep/simd/update.hpp"

namespace phistep::inline PHISTEP_ABI {

/// (1)
/// @tparam Factor  i ↦ h/m_i
template <class Scalar, class Factor>
struct Kick {
  Input<Scalar> v, psi;
  Factor factor;
  Kick(Input<Scalar> v0, Input<Scalar> f, Factor scale) : v{v0}, psi{f}, factor{scale} {}
  void operator()(auto i, auto& v1) const { v1 = v[i] + factor(i) * psi[i]; }
};

/// (2)
template <class Scalar, class Factor>
struct KickAndDrift {
  Input<Scalar> r, v, psi;
  Factor factor;
  Scalar before, after;  ///< [time]
  KickAndDrift(Input<Scalar> r0, Input<Scalar> v0, Input<Scalar> f, Factor scale, Scalar drift_before,
               Scalar drift_after)
      : r{r0}, v{v0}, psi{f}, factor{scale}, before{drift_before}, after{drift_after} {}
  void operator()(auto i, auto& v1, auto& r1) const {
    v1 = v[i] + factor(i) * psi[i];
    r1 = r[i] + (before * v[i] + after * v1);
  }
};
}  // namespace phistep::inline PHISTEP_ABI
