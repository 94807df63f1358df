/// @file
/// Elementary functions of plain numbers, under the same names as those of packs (pack_math.hpp), so that one generic law
/// serves both.
#pragma once

#include <cmath>
#include <concepts>
#include <type_traits>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// Templates, so that they give way to the C library's where both are visible.
template <std::floating_point T>
[[nodiscard]] T select(bool condition, T a, std::type_identity_t<T> b) {
  return condition ? a : b;
}
[[nodiscard]] constexpr bool any(std::same_as<bool> auto m) { return m; }
[[nodiscard]] constexpr bool all(std::same_as<bool> auto m) { return m; }
[[nodiscard]] constexpr bool none(std::same_as<bool> auto m) { return !m; }
template <std::floating_point T>
[[nodiscard]] T sum(T a) {
  return a;
}
template <std::floating_point T>
[[nodiscard]] T sqrt(T a) {
  return std::sqrt(a);
}
template <std::floating_point T>
[[nodiscard]] T exp(T a) {
  return std::exp(a);
}
template <std::floating_point T>
[[nodiscard]] T abs(T a) {
  return std::abs(a);
}
template <std::floating_point T>
[[nodiscard]] T min(const T& a, const T& b) {
  return b < a ? b : a;
}
template <std::floating_point T>
[[nodiscard]] T max(const T& a, const T& b) {
  return a < b ? b : a;
}
/// a b + c, rounded once where that costs nothing.
template <std::floating_point T>
[[nodiscard]] T fma(T a, T b, T c) {
#if !defined(PHISTEP_NO_SIMD) && (defined(__FMA__) || defined(__AVX512F__) || defined(__ARM_FEATURE_FMA))
  if constexpr (sizeof(T) <= 8) return std::fma(a, b, c);
#endif
  return a * b + c;
}
template <std::floating_point T>
[[nodiscard]] T reciprocal(T a) {
  return T{1} / a;
}
template <std::floating_point T>
[[nodiscard]] T rsqrt(T a) {
  return T{1} / std::sqrt(a);
}
template <std::floating_point T>
[[nodiscard]] T rsqrt3(T a) {
  return T{1} / (a * std::sqrt(a));
}
template <std::floating_point T>
[[nodiscard]] T pow(T x, std::type_identity_t<T> y) {
  return std::pow(x, y);
}

}}  // namespace phistep::PHISTEP_ABI
