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
  Kick(const Scalar* from, const Scalar* force, Factor h_by_m) : v{from}, psi{force}, factor{h_by_m} {}
  void operator()(auto i, auto& v1) const { v1 = v[i] + factor(i) * psi[i]; }
};

/// (2)
template <class Scalar, class Factor>
struct KickAndDrift {
  Input<Scalar> r, v, psi;
  Factor factor;
  Scalar before, after;  ///< [time]
  KickAndDrift(const Scalar* from_r, const Scalar* from_v, const Scalar* force, Factor h_by_m, Scalar h_before,
               Scalar h_after)
      : r{from_r}, v{from_v}, psi{force}, factor{h_by_m}, before{h_before}, after{h_after} {}
  void operator()(auto i, auto& v1, auto& r1) const {
    v1 = v[i] + factor(i) * psi[i];
    r1 = r[i] + (before * v[i] + after * v1);
  }
};

}  // namespace phistep::inline PHISTEP_ABI
