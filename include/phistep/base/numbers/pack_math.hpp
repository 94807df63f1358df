/// @file
/// Elementary functions of plain numbers and of packs under the same names, so that one generic law serves both.
///
/// Relative errors in units of the last place: + − * /, sqrt and fma ½; reciprocal and rsqrt 1; rsqrt3 2; exp 2.
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <limits>
#include <type_traits>

#include "phistep/base/numbers/pack.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// Of plain numbers. Templates, so that they give way to the C library's where both are visible.
template <std::floating_point T>
[[nodiscard]] T select(bool condition, T a, std::type_identity_t<T> b) {
  return condition ? a : b;
}
[[nodiscard]] constexpr bool any(std::same_as<bool> auto m) { return m; }
[[nodiscard]] constexpr bool all(std::same_as<bool> auto m) { return m; }
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

// Functions of packs.

/// The numbers in a T: itself, or a pack's.
template <class T>
struct ScalarIn {
  using type = T;
};
template <class Scalar, int width>
struct ScalarIn<Pack<Scalar, width>> {
  using type = Scalar;
};
template <class T>
inline constexpr bool is_pack = !std::is_same_v<T, typename ScalarIn<T>::type>;
template <class T>
concept PackOrNumber = std::floating_point<typename ScalarIn<T>::type>;

/// a b + c
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> fma(Pack<Scalar, width> a, std::type_identity_t<Pack<Scalar, width>> b,
                                      std::type_identity_t<Pack<Scalar, width>> c) {
  using P = Pack<Scalar, width>;
  [[maybe_unused]] constexpr auto bytes = sizeof(Scalar) * width;
  if constexpr (!detail::in_register<Scalar, width>) return P::make([&](int l) { return fma(a.x[l], b.x[l], c.x[l]); });
#if defined(__AVX512F__)
  else if constexpr (bytes == 64 && width == 8) return P{_mm512_fmadd_pd(a.x, b.x, c.x)};
  else if constexpr (bytes == 64) return P{_mm512_fmadd_ps(a.x, b.x, c.x)};
#endif
#if defined(__FMA__)
  else if constexpr (bytes == 32 && width == 4) return P{_mm256_fmadd_pd(a.x, b.x, c.x)};
  else if constexpr (bytes == 32) return P{_mm256_fmadd_ps(a.x, b.x, c.x)};
  else if constexpr (bytes == 16 && width == 2) return P{_mm_fmadd_pd(a.x, b.x, c.x)};
  else if constexpr (bytes == 16) return P{_mm_fmadd_ps(a.x, b.x, c.x)};
#endif
  else return P{a.x * b.x + c.x};
}

/// √a
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> sqrt(Pack<Scalar, width> a) {
  using P = Pack<Scalar, width>;
  [[maybe_unused]] constexpr auto bytes = detail::in_register<Scalar, width> ? sizeof(Scalar) * width : 0;
#if defined(__AVX512F__)
  // Masked by all ones: see base/numbers/fingerprint.hpp.
  if constexpr (bytes == 64 && width == 8) return P{_mm512_maskz_sqrt_pd(0xff, a.x)};
  else if constexpr (bytes == 64) return P{_mm512_maskz_sqrt_ps(0xffff, a.x)};
  else
#endif
#if defined(__AVX__)
      if constexpr (bytes == 32 && width == 4)
    return P{_mm256_sqrt_pd(a.x)};
  else if constexpr (bytes == 32) return P{_mm256_sqrt_ps(a.x)};
  else
#endif
#if defined(__SSE2__)
      if constexpr (bytes == 16 && width == 2)
    return P{_mm_sqrt_pd(a.x)};
  else if constexpr (bytes == 16) return P{_mm_sqrt_ps(a.x)};
  else
#endif
    return P::make([&](int l) { return std::sqrt(a[l]); });
}

template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> min(Pack<Scalar, width> a, std::type_identity_t<Pack<Scalar, width>> b) {
  using P [[maybe_unused]] = Pack<Scalar, width>;
  [[maybe_unused]] constexpr auto bytes = detail::in_register<Scalar, width> ? sizeof(Scalar) * width : 0;
  // x86's minimum of (b, a) is b < a ? b : a, with NaN and −0 too; g++ 12 doesn't find it in the select.
#if defined(__AVX512F__)
  if constexpr (bytes == 64 && width == 8) return P{_mm512_maskz_min_pd(0xff, b.x, a.x)};
  else if constexpr (bytes == 64) return P{_mm512_maskz_min_ps(0xffff, b.x, a.x)};
  else
#endif
#if defined(__AVX__)
      if constexpr (bytes == 32 && width == 4)
    return P{_mm256_min_pd(b.x, a.x)};
  else if constexpr (bytes == 32) return P{_mm256_min_ps(b.x, a.x)};
  else
#endif
#if defined(__SSE2__)
      if constexpr (bytes == 16 && width == 2)
    return P{_mm_min_pd(b.x, a.x)};
  else if constexpr (bytes == 16) return P{_mm_min_ps(b.x, a.x)};
  else
#endif
    return select(b < a, b, a);
}
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> max(Pack<Scalar, width> a, std::type_identity_t<Pack<Scalar, width>> b) {
  return select(a < b, b, a);
}
/// The greater one; b where one of them is NaN.
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> larger(Pack<Scalar, width> a, Pack<Scalar, width> b) {
  return select(a > b, a, b);
}
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> abs(Pack<Scalar, width> a) {
  using P = Pack<Scalar, width>;
  if constexpr (!detail::in_register<Scalar, width>) return P::make([&](int l) { return std::abs(a[l]); });
  else return bit_and(a, P{std::bit_cast<Scalar>(std::numeric_limits<detail::IntegerLike<Scalar>>::max())});
}
/// The nearest integer, for |a| < 2⁵¹ (float: 2²²).
template <PackOrNumber T>
[[nodiscard]] T nearest_integer(T a) {
  using Scalar = typename ScalarIn<T>::type;
  constexpr Scalar shift = Scalar{1.5} / std::numeric_limits<Scalar>::epsilon();
  return (a + shift) - shift;
}

namespace detail {
/// Whether there are estimates, to 2⁻¹⁴.
template <class P>
inline constexpr bool has_estimates = false;
template <class P>
[[nodiscard]] P rsqrt_estimate(P a);
template <class P>
[[nodiscard]] P reciprocal_estimate(P a);
#if defined(__AVX512F__)
template <class Scalar, int width>
inline constexpr bool has_estimates<Pack<Scalar, width>> = in_register<Scalar, width> && sizeof(Scalar) * width == 64;
template <class P>
P rsqrt_estimate(P a) {
  if constexpr (P::width == 8) return P{_mm512_maskz_rsqrt14_pd(0xff, a.x)};
  else return P{_mm512_maskz_rsqrt14_ps(0xffff, a.x)};
}
template <class P>
P reciprocal_estimate(P a) {
  if constexpr (P::width == 8) return P{_mm512_maskz_rcp14_pd(0xff, a.x)};
  else return P{_mm512_maskz_rcp14_ps(0xffff, a.x)};
}
#endif
}  // namespace detail

/// 1/a
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> reciprocal(Pack<Scalar, width> a) {
  using P = Pack<Scalar, width>;
  if constexpr (detail::has_estimates<P>) {
    const P y = detail::reciprocal_estimate(a), e = fma(-a, y, P{1});
    P better = fma(y, e, y);  // 2⁻²⁸
    if constexpr (sizeof(Scalar) == 8) better = fma(better, fma(-a, better, P{1}), better);
    return select(e == e, better, y);  // 1/0 and 1/∞ are right as they are
  } else {
    return 1 / a;
  }
}

/// 1/√a. With y = (1 + δ)/√a and e = 1 − a y²:  1/√a = y (1 − e)^−½ = y (1 + e/2 + 3/8 e² + 5/16 e³ + …)
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> rsqrt(Pack<Scalar, width> a) {
  using P = Pack<Scalar, width>;
  if constexpr (detail::has_estimates<P>) {
    const P y = detail::rsqrt_estimate(a), e = fma(-(a * y), y, P{1});  // |e| ≤ 2⁻¹³
    P series = P{0.5};
    if constexpr (sizeof(Scalar) == 8) series = fma(fma(e, P{0.3125}, P{0.375}), e, P{0.5});
    return select(e == e, fma(e * y, series, y), y);
  } else {
    return 1 / sqrt(a);
  }
}

/// a^(−3/2) = 1/(a √a), for 0 < a < ∞ with a³ in range: softened gravity's law. With y and e as in rsqrt it is
/// y³ (1 − e)^(−3/2) = y³ (1 + 3/2 e + 15/8 e² + 35/16 e³ + …).
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> rsqrt3(Pack<Scalar, width> a) {
  using P = Pack<Scalar, width>;
  if constexpr (detail::has_estimates<P>) {
    const P y = detail::rsqrt_estimate(a), y2 = y * y, e = fma(-a, y2, P{1}), y3 = y * y2;
    P series = P{1.5};
    if constexpr (sizeof(Scalar) == 8) series = fma(fma(e, P{2.1875}, P{1.875}), e, P{1.5});
    return fma(e * series, y3, y3);
  } else {
    return 1 / (a * sqrt(a));
  }
}

/// xⁿ by squaring, n known at compile time; 1/x^|n| for n < 0.
template <int n, class T>
[[nodiscard]] T pow(T x) {
  if constexpr (n < 0) return reciprocal(pow<-n>(x));
  else if constexpr (n == 0) return T{1};
  else if constexpr (n == 1) return x;
  else if constexpr (n % 2 == 1) return x * pow<n - 1>(x);
  else {
    const T half = pow<n / 2>(x);
    return half * half;
  }
}
/// xⁿ by squaring.
template <PackOrNumber T>
[[nodiscard]] T power(T x, int n) {
  T result{1};
  for (unsigned k = n < 0 ? 0u - static_cast<unsigned>(n) : static_cast<unsigned>(n); k > 0; k >>= 1) {
    if (k & 1u) result *= x;
    x *= x;
  }
  return n < 0 ? reciprocal(result) : result;
}
/// x^y, x ≥ 0. Whole and half exponents up to 32, which is what laws of force have, by squaring and a root; the others lane by lane
/// in the C library, some 20 ns each.
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> pow(Pack<Scalar, width> x, std::type_identity_t<Scalar> y) {
  const Scalar twice = 2 * y;
  if (std::abs(twice) <= 64 && twice == std::trunc(twice)) {
    const int n = static_cast<int>(twice);
    const auto whole = power(x, n / 2);
    return n % 2 == 0 ? whole : n > 0 ? whole * sqrt(x) : whole * rsqrt(x);
  }
  return Pack<Scalar, width>::make([&](int l) { return std::pow(x[l], y); });
}

/// eˣ = 2ⁿ eʳ, |r| ≤ ½ ln 2, by Taylor's series of degree 13 (float: 7), whose remainder is 4e-18 (5e-9). Below e⁻⁷⁰⁷ (float:
/// e⁻⁸⁶) 0, without the subnormal numbers; above the greatest number infinity.
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> exp(Pack<Scalar, width> x) {
  using P = Pack<Scalar, width>;
  if constexpr (!detail::in_register<Scalar, width>) {
    return P::make([&](int l) { return std::exp(x[l]); });
  } else {
    using Integers = typename detail::Storage<Scalar, width>::Integers;
    constexpr bool wide = sizeof(Scalar) == 8;
    constexpr int mantissa = wide ? 52 : 23, bias = wide ? 1023 : 127, degree = wide ? 13 : 7;
    constexpr Scalar shift = Scalar{1.5} / std::numeric_limits<Scalar>::epsilon();
    // ln 2 in two parts, the first with so few digits that n times it is exact.
    constexpr Scalar ln2_high = static_cast<Scalar>(wide ? 0x1.62e42fee00000p-1 : 0x1.62e400p-1);
    constexpr Scalar ln2_low = static_cast<Scalar>(wide ? 0x1.a39ef35793c76p-33 : 0x1.7f7d1cp-20);
    const P shifted = fma(x, P{1.442695040888963407}, P{shift}), n = shifted - P{shift};
    const P r = fma(-n, P{ln2_low}, fma(-n, P{ln2_high}, x));
    const auto inverse_factorial = [](int k) {
      double f = 1;
      for (int i = 2; i <= k; ++i) f /= i;
      return f;
    };
    P series{inverse_factorial(degree)};
    for (int k = degree - 1; k >= 0; --k) series = fma(series, r, P{inverse_factorial(k)});
    // The low bits of n + shift are n as an integer; 2ⁿ⁻¹ is put together from them, because 2¹⁰²⁴ does not exist.
    const Integers bits = reinterpret_cast<Integers>(shifted.x);
    const P scale{reinterpret_cast<typename P::Register>((bits + (bias - 1)) << mantissa)};
    const P value = (series + series) * scale;
    constexpr Scalar least = wide ? -707 : -86, most = static_cast<Scalar>(wide ? 709.782712893384 : 88.7228317);
    const P bounded = select(x < P{least}, P{0}, value);
    return select(x > P{most}, P{std::numeric_limits<Scalar>::infinity()}, bounded);
  }
}

}}  // namespace phistep::PHISTEP_ABI
