/// @file
/// What the systems of this folder have in common: tangents K = ∂Ψ/∂r and C = ∂Ψ/∂v (or ∂Ψ/∂y), kept apart from
/// W = M − γ_f C − γ_f γ_d K, so that a new γ costs no new Jacobian; factors of W; solves with them.
#pragma once

#include <Eigen/Core>

#include <concepts>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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
