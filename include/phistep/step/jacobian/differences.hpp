/// @file
/// ∂Ψ/∂y by forward differences: the increments, one force call a column. (One a group of columns: difference_tangent.hpp.)
///
/// Increments are √u·max(|y_j|, scale/16), with the scale taken from the block itself, so that no fixed length or unit
/// enters (constants such as 1e-5 break for atoms in metres); u is the unit round-off. No increment is below the least
/// normal number: of a state that has decayed to subnormal ones it would be zero.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>

#include "phistep/base/numbers/arithmetic.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Largest number of unknowns whose dense Jacobian is formed by differences; above it the constructor names the cures.
inline constexpr Eigen::Index dense_difference_limit = 1000;

/// Moves x by its increment; returns the one really made. Differences of an affine function are exact at any length, and
/// the longer the better: there, the increments are whole sizes and no root is taken.
template <bool affine, class Scalar>
[[nodiscard]] Scalar move_by_increment(Scalar& x, Scalar scale) {
  const Scalar kept = x;
  const Scalar relative = affine ? Scalar{1} : std::sqrt(std::numeric_limits<Scalar>::epsilon());
  x = kept + at_least_normal<Scalar>(relative * std::max(std::abs(kept), scale / Scalar{16}));
  // The increment as stored: exact, where the one wanted is off by a rounding.
  const volatile Scalar moved = x;
  return moved - kept;
}

/// How far γΨ/M kicks a block, its farthest component.
[[nodiscard]] double largest_kick(auto gamma, const auto& rate, const auto& mass) {
  double kicked = 0;
  const auto factor = mass.h_over_mass(gamma);
  for (Eigen::Index i = 0; i < rate.size(); ++i)
    kicked = std::max(kicked, std::abs(static_cast<double>(factor(i) * rate.data()[i])));
  return kicked;
}

}}  // namespace phistep::PHISTEP_ABI
