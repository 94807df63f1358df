/// @file
/// What the systems of this folder have in common: tangents K = ∂Ψ/∂r and C = ∂Ψ/∂v (or ∂Ψ/∂y), kept apart from
/// W = M − γ_f C − γ_f γ_d K, so that a new γ costs no new Jacobian; factors of W; solves with them.
#pragma once

#include <Eigen/Core>

#include <concepts>
#include <cstddef>
#include <utility>

#include "phistep/base/machine/only.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// K = ∂Ψ/∂r and C = ∂Ψ/∂v (or ∂Ψ/∂y) side by side, and their part of W = M − γ_f C − γ_f γ_d K.

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

/// put(i, j, m) for each entry of a mass matrix.
struct EachEntry {
  void operator()(auto&& put) const { put(Eigen::Index{}, Eigen::Index{}, 1); }
};

/// Takes the entries of tangents one by one, in any order, those of one place to be added up: of K where there is one, of C.
template <class System, class Scalar>
concept TakesEntries = requires(System& W, Eigen::Index i, Scalar x) {
  W.position(i, i, x);
  W.velocity(i, i, x);
  W.rate(i, i, x);                            // of a first-order state
  { W.magnitude() } -> std::same_as<double>;  // ‖W‖, largest entry
};

/// x ← W⁻¹ x, for some to a relative residual.
template <class System, class Vector>
concept SolvesExactly = requires(System& W, Vector& x) {
  { W.solve(x) } -> std::same_as<Outcome>;
};
template <class System, class Vector>
concept SolvesToTolerance = requires(System& W, Vector& x, double rtol, Statistics& counts) {
  { W.solve(x, rtol, counts) } -> std::same_as<Outcome>;
};

/// Makes factors of W out of its tangents.
template <class System, class Scalar>
concept Factorizes = requires(System& W, Eigen::Index size, Scalar gamma, const EachEntry& masses, Statistics& counts) {
  W.resize(size);
  W.clear();  // the tangents, before new ones
  { W.is_finite() } -> std::same_as<bool>;
  { W.factorize(masses, gamma, gamma, counts) } -> std::same_as<Outcome>;  // for γ_f, γ_d
  { W.drift_share() } -> std::same_as<double>;  // ‖γ_f γ_d K‖ / ‖W‖, row by row or of all: how much of r the solve sees
};

/// W of n unknowns.
template <class System, class Scalar, int n = Eigen::Dynamic>
concept LinearSystem = Factorizes<System, Scalar> &&
    (SolvesExactly<System, Eigen::Matrix<Scalar, n, 1>> || SolvesToTolerance<System, Eigen::Matrix<Scalar, n, 1>>);

}}  // namespace phistep::PHISTEP_ABI
