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
  void operator()(auto i, auto& v1) const { v1 = v[i] + factor(i) * psi[i]; }
};
template <class Scalar, class Factor>
Kick(Input<Scalar>, Input<Scalar>, Factor) -> Kick<Scalar, Factor>;

/// (2)
template <class Scalar, class Factor>
struct KickAndDrift {
  Input<Scalar> r, v, psi;
  Factor factor;
  Scalar before, after;  ///< [time]
  void operator()(auto i, auto& v1, auto& r1) const {
    v1 = v[i] + factor(i) * psi[i];
    r1 = r[i] + (before * v[i] + after * v1);
  }
};
template <class Scalar, class Factor>
KickAndDrift(Input<Scalar>, Input<Scalar>, Input<Scalar>, Factor, Scalar, Scalar) -> KickAndDrift<Scalar, Factor>;

}  // namespace phistep::inline PHISTEP_ABI
