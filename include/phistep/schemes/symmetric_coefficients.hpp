/// @file
/// Coefficients of symmetric compositions, which read the same from behind: a table has those up to the centre.
#pragma once

#include <cstddef>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Coefficient i of n that sum to one: those given, from both ends, and in the centre what they leave.
template <class Scalar, std::size_t given>
[[nodiscard]] constexpr Scalar symmetric_coefficient(const long double (&coefficients)[given], std::size_t n,
                                                     std::size_t i) {
  const std::size_t from_end = i < n - 1 - i ? i : n - 1 - i;
  if (from_end < given) return static_cast<Scalar>(coefficients[from_end]);
  Scalar sum{0};
  for (const long double x : coefficients) sum += static_cast<Scalar>(x);
  return n % 2 == 1 ? 1 - 2 * sum : Scalar{0.5L} - sum;
}

}}  // namespace phistep::PHISTEP_ABI
