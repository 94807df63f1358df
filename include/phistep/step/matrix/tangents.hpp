/// @file
/// K = ∂Ψ/∂r and C = ∂Ψ/∂v (or ∂Ψ/∂y) side by side, and their part of W = M − γ_f C − γ_f γ_d K.
#pragma once

#include <cstddef>
#include <utility>

#include "phistep/base/machine/only.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// n rows with `lower` diagonals below the main one and `upper` above.
struct BandWidth {
  std::ptrdiff_t n = 0, lower = 0, upper = 0;
};

/// K and C in Eigen arrays of any shape, kept apart from W so that a new γ costs no new Jacobian. One that is always zero isn't
/// there; where neither would be, a C of zeros is.
template <class Array, bool has_K, bool has_C>
struct Tangents {
  using Scalar = typename Array::Scalar;
  static constexpr bool stores_C = has_C || !has_K;
  [[no_unique_address]] Only<has_K, Array, 0> K;
  [[no_unique_address]] Only<stores_C, Array, 1> C;

  /// All to zero.
  void resize(auto... size) {
    for_each([&](Array& x) { x.setZero(size...); });
  }
  void clear() {
    for_each([](Array& x) { x.setZero(); });
  }
  void for_each(auto&& f) {
    if constexpr (has_K) f(K);
    if constexpr (stores_C) f(C);
  }
  [[nodiscard]] bool is_finite() const {
    bool finite = true;
    if constexpr (has_K) finite = finite && all_finite(K.data(), K.size());
    if constexpr (stores_C) finite = finite && all_finite(C.data(), C.size());
    return finite;
  }
  [[nodiscard]] auto rows() const {
    if constexpr (has_K) return K.rows();
    else return C.rows();
  }
  /// The entries of K and C at one place, zero for what isn't there.
  [[nodiscard]] std::pair<Scalar, Scalar> at(auto... place) const {
    std::pair<Scalar, Scalar> entries{};
    if constexpr (has_K) entries.first = K(place...);
    if constexpr (has_C) entries.second = C(place...);
    return entries;
  }
  /// −γ_f (C + γ_d K), an expression; of what `view` sees of both.
  [[nodiscard]] auto part(Scalar gamma_force, Scalar gamma_drift, auto view) const {
    if constexpr (has_K && has_C) return -gamma_force * (view(C) + gamma_drift * view(K));
    else if constexpr (has_K) return (-gamma_force * gamma_drift) * view(K);
    else return -gamma_force * view(C);
  }
  [[nodiscard]] auto part(Scalar gamma_force, Scalar gamma_drift) const {
    return part(gamma_force, gamma_drift, [](const Array& x) -> const Array& { return x; });
  }
};

}}  // namespace phistep::PHISTEP_ABI
