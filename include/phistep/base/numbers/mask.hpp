/// @file
/// The registers of the machine, and a truth value a lane: what `Pack` (base/numbers/pack.hpp) is made of.
#pragma once

#include <cstdint>
#include <functional>
#include <type_traits>

#include "phistep/base/version.hpp"

#if defined(__AVX__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace phistep { inline namespace PHISTEP_ABI {

/// [bytes] of the widest register, 0 where packs are arrays.
#if defined(PHISTEP_NO_SIMD) || !defined(__GNUC__)
inline constexpr int simd_bytes = 0;
#elif defined(__AVX512F__)
inline constexpr int simd_bytes = 64;
#elif defined(__AVX__)
inline constexpr int simd_bytes = 32;
#elif defined(__SSE2__) || (defined(__ARM_NEON) && defined(__aarch64__))
inline constexpr int simd_bytes = 16;
#else
inline constexpr int simd_bytes = 0;
#endif

/// Lanes of the widest register: 1 where there is none.
template <class Scalar>
inline constexpr int native_width = simd_bytes > 0 && (std::is_same_v<Scalar, double> || std::is_same_v<Scalar, float>)
                                        ? simd_bytes / static_cast<int>(sizeof(Scalar))
                                        : 1;

namespace detail {

/// What a compiler's vector does, without one.
template <class T, int width>
struct Lanes {
  T lane[width];
  constexpr T operator[](int i) const { return lane[i]; }
  constexpr T& operator[](int i) { return lane[i]; }
  template <class F, class... A>
  static constexpr auto map(F f, const A&... a) {
    Lanes<decltype(f(a[0]...)), width> out{};
    for (int i = 0; i < width; ++i) out.lane[i] = f(a[i]...);
    return out;
  }
  friend constexpr Lanes operator-(Lanes a) { return map(std::negate<>{}, a); }
  friend constexpr Lanes operator+(Lanes a, Lanes b) { return map(std::plus<>{}, a, b); }
  friend constexpr Lanes operator-(Lanes a, Lanes b) { return map(std::minus<>{}, a, b); }
  friend constexpr Lanes operator*(Lanes a, Lanes b) { return map(std::multiplies<>{}, a, b); }
  friend constexpr Lanes operator/(Lanes a, Lanes b) { return map(std::divides<>{}, a, b); }
  // Operators of truth values.
  friend constexpr Lanes operator&(Lanes a, Lanes b) { return map(std::logical_and<>{}, a, b); }
  friend constexpr Lanes operator|(Lanes a, Lanes b) { return map(std::logical_or<>{}, a, b); }
  friend constexpr Lanes operator~(Lanes a) { return map(std::logical_not<>{}, a); }
};

template <class Scalar, int width>
inline constexpr bool in_register = static_cast<int>(sizeof(Scalar)) * width <= simd_bytes&& width > 1;
template <class Scalar>
using IntegerLike = std::conditional_t<sizeof(Scalar) == 4, std::int32_t, std::int64_t>;

/// AVX-512 keeps a bit a lane, the others a whole integer of ones or zeros, arrays a bool.
enum class MaskKind { bits, integers, bools };
template <class Scalar, int width>
inline constexpr MaskKind mask_kind = !in_register<Scalar, width>    ? MaskKind::bools
                                      : sizeof(Scalar) * width == 64 ? MaskKind::bits
                                                                     : MaskKind::integers;

template <class Scalar, int width, MaskKind = mask_kind<Scalar, width>>
struct Storage {
  using Register = Lanes<Scalar, width>;
  using Bits = Lanes<bool, width>;
};
#if defined(__GNUC__)
// Three times, because g++ drops the vector attribute of a template's argument.
template <class Scalar, int width>
struct Storage<Scalar, width, MaskKind::integers> {
  typedef Scalar Register __attribute__((vector_size(sizeof(Scalar) * width)));
  typedef IntegerLike<Scalar> Integers __attribute__((vector_size(sizeof(Scalar) * width)));
  typedef IntegerLike<Scalar> Bits __attribute__((vector_size(sizeof(Scalar) * width)));
};
template <class Scalar, int width>
struct Storage<Scalar, width, MaskKind::bits> {
  typedef Scalar Register __attribute__((vector_size(sizeof(Scalar) * width)));
  typedef IntegerLike<Scalar> Integers __attribute__((vector_size(sizeof(Scalar) * width)));
  using Bits = std::conditional_t<width == 8, std::uint8_t, std::uint16_t>;
};
#endif

}  // namespace detail

/// A truth value a lane.
template <class Scalar, int width>
struct Mask {
  static constexpr auto kind = detail::mask_kind<Scalar, width>;
  using Bits = typename detail::Storage<Scalar, width>::Bits;
  Bits lanes;

  [[nodiscard]] friend Mask operator&(Mask a, Mask b) { return {static_cast<Bits>(a.lanes & b.lanes)}; }
  [[nodiscard]] friend Mask operator|(Mask a, Mask b) { return {static_cast<Bits>(a.lanes | b.lanes)}; }
  [[nodiscard]] friend Mask operator!(Mask a) { return {static_cast<Bits>(~a.lanes)}; }
  [[nodiscard]] friend Mask operator&&(Mask a, Mask b) { return a & b; }
  [[nodiscard]] friend Mask operator||(Mask a, Mask b) { return a | b; }
  /// Bit l: lane l.
  [[nodiscard]] unsigned bits() const {
    if constexpr (kind == detail::MaskKind::bits) return lanes;
#if defined(__SSE2__)
    else if constexpr (kind == detail::MaskKind::integers && sizeof(Bits) == 16) {
      if constexpr (width == 2) return static_cast<unsigned>(_mm_movemask_pd(reinterpret_cast<__m128d>(lanes)));
      else return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(lanes)));
    }
#endif
#if defined(__AVX__)
    else if constexpr (kind == detail::MaskKind::integers && sizeof(Bits) == 32) {
      if constexpr (width == 4) return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(lanes)));
      else return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(lanes)));
    }
#endif
    else {
      unsigned all = 0;
      for (int l = 0; l < width; ++l) all |= (lanes[l] ? 1u : 0u) << l;
      return all;
    }
  }
  [[nodiscard]] bool operator[](int lane) const { return bits() >> lane & 1u; }
};
template <class Scalar, int width>
[[nodiscard]] bool any(Mask<Scalar, width> m) {
  return m.bits() != 0;
}
template <class Scalar, int width>
[[nodiscard]] bool all(Mask<Scalar, width> m) {
  return m.bits() == (1u << width) - 1;
}

}}  // namespace phistep::PHISTEP_ABI
