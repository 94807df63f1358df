/// @file
/// Pivots shared by matrices that are factorized side by side, one a lane (lane_lu.hpp), and sparse or banded: there, a
/// row in its place spares fill.
#pragma once

#include <limits>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Multipliers up to this are trusted (threshold pivoting, I. S. Duff, A. M. Erisman & J. K. Reid, Direct Methods for
/// Sparse Matrices, sect. 5.2).
inline constexpr int largest_lane_multiplier = 8;

/// Of the entries at(0) … at(count − 1) of a column the first, where no lane's multipliers are too large with it; else the
/// one whose worst lane is best beside that lane's largest entry.
template <class Number, class Count>
[[nodiscard]] Count lane_pivot(Count count, auto&& at) {
  using Real = typename Number::Real;
  using Scalar = typename Real::Scalar;
  constexpr auto trusted = static_cast<Scalar>(largest_lane_multiplier * largest_lane_multiplier);
  const Real first = at(Count{0}).norm();
  Real best = first;
  for (Count i = 1; i < count; ++i) best = larger(at(i).norm(), best);
  if (all_at_least(first * Real{trusted}, best)) return Count{0};
  // 0 and NaN are found by is_lane_pivot.
  const Real by = Real{Scalar{1}} / best;
  constexpr int lanes = sizeof(Real) / sizeof(Scalar);
  Count chosen{0};
  Scalar share{-1};
  for (Count i = 0; i < count; ++i) {
    const Real x = at(i).norm() * by;
    Scalar worst = x[0];
    for (int l = 1; l < lanes; ++l) worst = x[l] < worst ? x[l] : worst;
    if (worst > share) share = worst, chosen = i;
  }
  return chosen;
}
/// False where a lane's pivot is zero, not finite, or has a square that leaves the range.
template <class Number>
[[nodiscard]] bool is_lane_pivot(const Number& pivot) {
  using Real = typename Number::Real;
  using Scalar = typename Real::Scalar;
  const Real size = pivot.norm();
  return all_at_least(size, Real{least_normal<Scalar>}) && all_at_least(Real{std::numeric_limits<Scalar>::max()}, size);
}

}}  // namespace phistep::PHISTEP_ABI
