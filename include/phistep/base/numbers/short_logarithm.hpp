/// @file
/// log₂ x and 2^x to 3e-7 of what they are: more than a step length needs, and short, inline and the same on every machine.
#pragma once

#include <bit>
#include <cstdint>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// log₂ x of a finite normal x > 0: that of its power of two, and a polynomial for what is left, between √½ and √2.
[[nodiscard, gnu::always_inline]] inline double short_log2(double x) {
  constexpr std::uint64_t root_of_half = 0x3fe6a09e667f3bcd;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const std::int64_t power = static_cast<std::int64_t>(bits - root_of_half) >> 52;
  const double t = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(power) << 52)) - 1, s = t * t;
  const double low =
      (1.44269499489304656 - 0.721352931362974142 * t) + s * (0.48091670800022001 - 0.360225182460989429 * t);
  const double high =
      (0.287288882373974613 - 0.249271822074913675 * t) + s * (0.232652578821136235 - 0.142759734359919774 * t);
  return static_cast<double>(power) + t * (low + s * s * high);
}
/// 2^x for |x| < 1000: 2 to the nearest integer, and a polynomial for what is left.
[[nodiscard, gnu::always_inline]] inline double short_exp2(double x) {
  constexpr double integers = 6755399441055744;  // 1.5·2⁵²: numbers beside it have no fraction
  const double rounded = x + integers, t = x - (rounded - integers), s = t * t;
  const double low =
      (0.693147180559945309 + 0.240223490380203614 * t) + s * (0.0555038101379645743 + 0.00966636851538544831 * t);
  const double fraction = 1 + t * (low + s * s * 0.00133813025373207962);
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(fraction) + (std::bit_cast<std::uint64_t>(rounded) << 52));
}

}}  // namespace phistep::PHISTEP_ABI
