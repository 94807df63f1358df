/// @file
/// What the systems of this folder have in common: tangents K = ∂Ψ/∂r and C = ∂Ψ/∂v (or ∂Ψ/∂y), kept apart from
/// W = M − γ_f C − γ_f γ_d K, so that a new γ costs no new Jacobian; factors of W; solves with them.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <concepts>
#include <cstddef>
#include <utility>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"

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

  /// Sets all entries to zero.
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
  /// The largest max_j |K_ij| / max_j |W_ij| of all rows i: by rows, since a heavy component must not hide how stiff others are.
  [[nodiscard]] double largest_share(const Array& W) const {
    if constexpr (has_K)
      if (K.size() > 0)
        return static_cast<double>(
            (K.cwiseAbs().rowwise().maxCoeff().array() / W.cwiseAbs().rowwise().maxCoeff().array()).maxCoeff());
    return 0;
  }
  /// The entries of K and C at one place, zero for what isn't there.
  [[nodiscard]] std::pair<Scalar, Scalar> at(auto... place) const {
    std::pair<Scalar, Scalar> entries{};
    if constexpr (has_K) entries.first = K(place...);
    if constexpr (has_C) entries.second = C(place...);
    return entries;
  }
  /// −γ_f (C + γ_d K), an expression
  [[nodiscard]] auto part(Scalar gamma_force, Scalar gamma_drift) const {
    if constexpr (has_K && has_C) return -gamma_force * (C + gamma_drift * K);
    else if constexpr (has_K) return (-gamma_force * gamma_drift) * K;
    else return -gamma_force * C;
  }
};

/// What a system need not have. Linearization asks each for all of it.
class SystemDefaults {
 public:
  static void take(const auto& /*linear*/) {}                    ///< the user's linear solver
  static void begin_anew() {}                                    ///< forgets what solves have found out about W
  static void forget_pattern() {}                                ///< forgets W's pattern, with what was made of it
  static void scale_rows_by(auto&& /*weigh*/, auto /*rtol*/) {}  ///< see RowScales::begin
  [[nodiscard]] static bool has_solver() { return true; }        ///< false in a copy that has one to make
  [[nodiscard]] static Eigen::Index singular_particle() { return -1; }
  [[nodiscard]] static const char* name(const char* of_row) { return of_row; }

  /// How much of W's entries K makes, and how large they are.
  void set(double drift_share, double magnitude) { drift_share_ = drift_share, magnitude_ = magnitude; }
  [[nodiscard]] double drift_share() const { return drift_share_; }
  [[nodiscard]] double magnitude() const { return magnitude_; }

 private:
  double drift_share_ = 0, magnitude_ = 0;
};

/// put(i, j, m) for each entry of a mass matrix.
struct EachEntry {
  void operator()(auto&& put) const { put(Eigen::Index{}, Eigen::Index{}, 1); }
};

/// x ← W⁻¹ x to a relative residual.
template <class System, class Vector>
concept SolvesToTolerance = requires(System& W, Vector& x, double rtol, Statistics& counts) {
  { W.solve(x, rtol, counts) } -> std::same_as<Outcome>;
};

/// W of n unknowns, which makes factors out of its tangents.
template <class System, class Scalar, int n = Eigen::Dynamic, class Vector = Eigen::Matrix<Scalar, n, 1>>
concept LinearSystem = requires(System& W, Vector& x, Eigen::Index size, Scalar gamma, const EachEntry& masses,
                                Statistics& counts) {
  W.resize(size);
  W.clear();  // the tangents, before new ones
  { W.is_finite() } -> std::same_as<bool>;
  { W.factorize(masses, gamma, gamma, counts) } -> std::same_as<Outcome>;  // for γ_f, γ_d
  { W.drift_share() } -> std::same_as<double>;  // ‖γ_f γ_d K‖ / ‖W‖, row by row, or so: how much of r the solve sees
  requires SolvesToTolerance<System, Vector> || requires {
    { W.solve(x) } -> std::same_as<Outcome>;  // x ← W⁻¹ x
  };
};

}}  // namespace phistep::PHISTEP_ABI
