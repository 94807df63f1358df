/// @file
/// Several numbers as one: `Pack<Scalar, width>`, arithmetic and comparisons lane by lane.
///
///     auto law = [](auto r2) { return select(r2 < 6.25, 1 / (r2 * r2), 0 * r2); };   // for a number and for a Pack
///
/// Built on the vectors of g++ and clang; where the machine has no register of that size (another compiler, another
/// machine, or PHISTEP_NO_SIMD) the same type is an array that the compiler may vectorize or not.
/// <experimental/simd> instead: a kernel of gravity and one of Lennard-Jones with a cutoff run alike under g++ 12 (1.00 : 1.00
/// for SSE2, AVX2 and AVX-512); under clang 14 and AVX-512 its masks made the second 2.2 × slower, and wrong. It costs 0.65 s
/// more to include, and libc++ lacks it.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <utility>

#include "phistep/base/numbers/mask.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// `width` numbers.
template <class Scalar_, int width_>
struct Pack {
  static_assert(width_ > 0 && width_ <= 16 && (width_ & (width_ - 1)) == 0);
  using Scalar = Scalar_;
  static constexpr int width = width_;
  using Register = typename detail::Storage<Scalar, width>::Register;
  using Truth = Mask<Scalar, width>;
  Register x;

  Pack() = default;
  explicit constexpr Pack(Register lanes) : x{lanes} {}
  /// The same number in every lane. From any arithmetic type: parameters of laws are double also where particles are
  /// float.
  template <class Number>
    requires std::is_arithmetic_v<Number>
  constexpr Pack(Number s) : x{broadcast(static_cast<Scalar>(s), std::make_integer_sequence<int, width>{})} {}

  [[nodiscard]] static Pack load(const Scalar* p) {
    Pack a;
    std::memcpy(&a.x, p, sizeof a.x);
    return a;
  }
  void store(Scalar* p) const { std::memcpy(p, &x, sizeof x); }
  /// p is a multiple of the pack's size. (libc++ 14 has no std::assume_aligned.)
#if defined(__GNUC__)
  [[nodiscard]] static Pack load_aligned(const Scalar* p) {
    return load(static_cast<const Scalar*>(__builtin_assume_aligned(p, sizeof(Register))));
  }
  void store_aligned(Scalar* p) const { store(static_cast<Scalar*>(__builtin_assume_aligned(p, sizeof(Register)))); }
#else
  [[nodiscard]] static Pack load_aligned(const Scalar* p) { return load(p); }
  void store_aligned(Scalar* p) const { store(p); }
#endif
  /// p[index[l]] in lane l.
  template <std::integral Index>
  [[nodiscard]] static Pack gather(const Scalar* p, const Index* index) {
    return make([&](int l) { return p[index[l]]; });
  }
  /// f(l) in lane l.
  template <class F>
  [[nodiscard]] static Pack make(F&& f) {
    return [&]<int... l>(std::integer_sequence<int, l...>) { return Pack{Register{f(l)...}}; }
    (std::make_integer_sequence<int, width>{});
  }
  [[nodiscard]] Scalar operator[](int lane) const { return x[lane]; }

  [[nodiscard]] friend Pack operator+(Pack a, Pack b) { return Pack{a.x + b.x}; }
  [[nodiscard]] friend Pack operator-(Pack a, Pack b) { return Pack{a.x - b.x}; }
  [[nodiscard]] friend Pack operator*(Pack a, Pack b) { return Pack{a.x * b.x}; }
  [[nodiscard]] friend Pack operator/(Pack a, Pack b) { return Pack{a.x / b.x}; }
  [[nodiscard]] Pack operator-() const { return Pack{-x}; }
  Pack& operator+=(Pack b) { return *this = *this + b; }
  Pack& operator-=(Pack b) { return *this = *this - b; }
  Pack& operator*=(Pack b) { return *this = *this * b; }
  Pack& operator/=(Pack b) { return *this = *this / b; }

  // Comparisons with NaN are false, != is true: as for numbers.
  [[nodiscard]] friend Truth operator<(Pack a, Pack b) { return compare<0x11>(a, b); }
  [[nodiscard]] friend Truth operator<=(Pack a, Pack b) { return compare<0x12>(a, b); }
  [[nodiscard]] friend Truth operator>(Pack a, Pack b) { return compare<0x11>(b, a); }
  [[nodiscard]] friend Truth operator>=(Pack a, Pack b) { return compare<0x12>(b, a); }
  [[nodiscard]] friend Truth operator==(Pack a, Pack b) { return compare<0x00>(a, b); }
  [[nodiscard]] friend Truth operator!=(Pack a, Pack b) { return compare<0x04>(a, b); }

 private:
  template <int... l>
  static constexpr Register broadcast(Scalar s, std::integer_sequence<int, l...>) {
    return Register{(static_cast<void>(l), s)...};
  }
  /// code: the immediate of x86's compare, LT_OQ, LE_OQ, EQ_OQ and NEQ_UQ.
  template <int code>
  static Truth compare(Pack a, Pack b) {
    [[maybe_unused]] const auto by = [](const auto& p, const auto& q) {
      if constexpr (code == 0x11) return p < q;
      else if constexpr (code == 0x12) return p <= q;
      else if constexpr (code == 0x00) return p == q;
      else return p != q;
    };
    if constexpr (Truth::kind == detail::MaskKind::bools) return {Register::map(by, a.x, b.x)};
#if defined(__AVX512F__)
    else if constexpr (Truth::kind == detail::MaskKind::bits && sizeof(Scalar) == 8)
      return {_mm512_cmp_pd_mask(a.x, b.x, code)};
    else if constexpr (Truth::kind == detail::MaskKind::bits) return {_mm512_cmp_ps_mask(a.x, b.x, code)};
#endif
    else return {by(a.x, b.x)};
  }
};

/// a where the mask is true, b elsewhere.
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> select(Mask<Scalar, width> m, std::type_identity_t<Pack<Scalar, width>> a,
                                         std::type_identity_t<Pack<Scalar, width>> b) {
  using P = Pack<Scalar, width>;
  if constexpr (m.kind == detail::MaskKind::bools) return P::make([&](int l) { return m.lanes[l] ? a.x[l] : b.x[l]; });
#if defined(__AVX512F__)
  else if constexpr (m.kind == detail::MaskKind::bits && sizeof(Scalar) == 8)
    return P{_mm512_mask_blend_pd(m.lanes, b.x, a.x)};
  else if constexpr (m.kind == detail::MaskKind::bits) return P{_mm512_mask_blend_ps(m.lanes, b.x, a.x)};
#endif
  else return P{m.lanes ? a.x : b.x};
}

/// Bit by bit.
template <class Scalar, int width, class F>
[[nodiscard]] Pack<Scalar, width> bitwise(Pack<Scalar, width> a, Pack<Scalar, width> b, F f) {
  using P = Pack<Scalar, width>;
  if constexpr (detail::in_register<Scalar, width>) {
    using Integers = typename detail::Storage<Scalar, width>::Integers;
    return P{
        reinterpret_cast<typename P::Register>(f(reinterpret_cast<Integers>(a.x), reinterpret_cast<Integers>(b.x)))};
  } else {
    using Integer = detail::IntegerLike<Scalar>;
    return P::make(
        [&](int l) { return std::bit_cast<Scalar>(f(std::bit_cast<Integer>(a[l]), std::bit_cast<Integer>(b[l]))); });
  }
}
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> bit_and(Pack<Scalar, width> a, Pack<Scalar, width> b) {
  return bitwise(a, b, [](auto x, auto y) { return x & y; });
}
template <class Scalar, int width>
[[nodiscard]] Pack<Scalar, width> bit_or(Pack<Scalar, width> a, Pack<Scalar, width> b) {
  return bitwise(a, b, [](auto x, auto y) { return x | y; });
}

/// True in the first n lanes: the tail of an array.
template <class Pack>
[[nodiscard]] typename Pack::Truth first_lanes(std::ptrdiff_t n) {
  using Truth = typename Pack::Truth;
  if constexpr (Truth::kind == detail::MaskKind::bits)
    return {static_cast<typename Truth::Bits>(n >= Pack::width ? ~0u : (1u << n) - 1u)};
  else
    return Pack::make([](int l) { return static_cast<typename Pack::Scalar>(l); }) <
           Pack(n < Pack::width ? n : std::ptrdiff_t{Pack::width});
}

/// f of the lanes, two at a time, always as a tree of halves: (l, l + width/2) first.
template <class Scalar, int width, class F>
[[nodiscard]] Scalar fold(Pack<Scalar, width> a, F f) {
  if constexpr (width == 1) return a[0];
  else {
    constexpr int half = width / 2;
    using Half = Pack<Scalar, half>;
#if defined(__GNUC__)
    if constexpr (detail::in_register<Scalar, half> && detail::in_register<Scalar, width>)
      return [&]<int... l>(std::integer_sequence<int, l...>) {
        return fold(
            f(Half{__builtin_shufflevector(a.x, a.x, l...)}, Half{__builtin_shufflevector(a.x, a.x, (l + half)...)}),
            f);
      }
    (std::make_integer_sequence<int, half>{});
    else
#endif
        return fold(f(Half::make([&](int l) { return a[l]; }), Half::make([&](int l) { return a[l + half]; })), f);
  }
}
/// The lanes added up.
template <class Scalar, int width>
[[nodiscard]] Scalar sum(Pack<Scalar, width> a) {
  return fold(a, [](auto x, auto y) { return x + y; });
}

// Passes over arrays, a pack of the machine's width at a time.

/// The numbers i, i + 1 … i + width − 1 of arrays.
template <class Scalar, int width>
struct From {
  std::ptrdiff_t i;
  [[nodiscard, gnu::always_inline]] inline Pack<Scalar, width> operator()(const Scalar* p) const {
    return Pack<Scalar, width>::load(p + i);
  }
  friend From operator+(From from, std::ptrdiff_t n) { return {from.i + n}; }
};
/// f(From) for all of 0 … n − 1: as many at once as a register holds, and the rest one by one.
template <class Scalar, int width = native_width<Scalar>>
[[gnu::always_inline]] inline void for_each_pack(std::ptrdiff_t n, auto&& f) {
  const std::ptrdiff_t whole = n - n % width;  // so that g++ sees the second loop's end where n is a constant
  for (std::ptrdiff_t i = 0; i < whole; i += width) f(From<Scalar, width>{i});
  if constexpr (width > 1)
    for (std::ptrdiff_t i = whole; i < n; ++i) f(From<Scalar, 1>{i});
}
/// A sum over such a pass.
template <class Scalar>
struct PackSum {
  Pack<Scalar, native_width<Scalar>> packs{0};
  Scalar rest{0};
  template <int width>
  void add(Pack<Scalar, width> x) {
    if constexpr (width == native_width<Scalar>) packs += x;
    else rest += x[0];
  }
  [[nodiscard]] Scalar total() const { return sum(packs) + rest; }
};

/// The x, y, z and w of P::width structs, a pack of each.
template <class P>
struct FourPacks {
  P x, y, z, w;
};

/// Structs of four numbers at xyzw + 4·slot[l], transposed: loads of a whole struct and shuffles, which beat the hardware's
/// gathers two to one.
template <class P>
[[nodiscard]] FourPacks<P> gather4(const typename P::Scalar* xyzw, const std::integral auto* slot) {
  using Scalar = typename P::Scalar;
  constexpr int width = P::width;
  const auto at = [&](int l) { return xyzw + std::ptrdiff_t{4} * slot[l]; };
#if defined(__GNUC__)
  if constexpr (detail::in_register<Scalar, width> && width == 2) {
    const auto a = P::load(at(0)).x, b = P::load(at(1)).x, c = P::load(at(0) + 2).x, d = P::load(at(1) + 2).x;
    return {P{__builtin_shufflevector(a, b, 0, 2)}, P{__builtin_shufflevector(a, b, 1, 3)},
            P{__builtin_shufflevector(c, d, 0, 2)}, P{__builtin_shufflevector(c, d, 1, 3)}};
  } else if constexpr (detail::in_register<Scalar, width>) {
    using Quad = Pack<Scalar, 4>;
    // Row k: the structs k, k + 4, k + 8 … side by side.
    const auto row = [&](int k) {
      const auto quad = [&](int l) { return Quad::load(at(l)).x; };
      const auto join = [](auto a, auto b) {
        return [&]<int... i>(std::integer_sequence<int, i...>) { return __builtin_shufflevector(a, b, i...); }
        (std::make_integer_sequence<int, 2 * sizeof(a) / sizeof(Scalar)>{});
      };
      if constexpr (width == 4) return quad(k);
#if defined(__AVX512F__)
      // Loads that put a struct to where it stands in the register, in the place of shuffles.
      else if constexpr (sizeof(Scalar) == 8 && width == 8)
        return _mm512_mask_broadcast_f64x4(_mm512_castpd256_pd512(quad(k)), 0xf0, quad(k + 4));
      else if constexpr (width == 16) {
        __m512 all = _mm512_castps128_ps512(quad(k));
        all = _mm512_mask_broadcast_f32x4(all, 0x00f0, quad(k + 4));
        all = _mm512_mask_broadcast_f32x4(all, 0x0f00, quad(k + 8));
        return _mm512_mask_broadcast_f32x4(all, 0xf000, quad(k + 12));
      }
#endif
      else if constexpr (width == 8)
        return join(quad(k), quad(k + 4));
      else return join(join(quad(k), quad(k + 4)), join(quad(k + 8), quad(k + 12)));
    };
    // In each group of four lanes: a < 4 from the first, a ≥ 4 from the second.
    const auto mix =
        []<int... a, int... i>(auto p, auto q, std::integer_sequence<int, a...>, std::integer_sequence<int, i...>) {
      constexpr int pattern[] = {a...};
      return P{__builtin_shufflevector(p.x, q.x, (pattern[i % 4] / 4 * width + pattern[i % 4] % 4 + i / 4 * 4)...)};
    };
    constexpr auto lanes = std::make_integer_sequence<int, width>{};
    using First = std::integer_sequence<int, 0, 1, 4, 5>;
    using Last = std::integer_sequence<int, 2, 3, 6, 7>;
    const P r0{row(0)}, r1{row(1)}, r2{row(2)}, r3{row(3)};
    if constexpr (sizeof(Scalar) == 8) {  // pairs of 8 bytes can be unpacked
      using Even = std::integer_sequence<int, 0, 4, 2, 6>;
      using Odd = std::integer_sequence<int, 1, 5, 3, 7>;
      const P xz = mix(r0, r1, Even{}, lanes), xz2 = mix(r2, r3, Even{}, lanes);
      const P yw = mix(r0, r1, Odd{}, lanes), yw2 = mix(r2, r3, Odd{}, lanes);
      return {mix(xz, xz2, First{}, lanes), mix(yw, yw2, First{}, lanes), mix(xz, xz2, Last{}, lanes),
              mix(yw, yw2, Last{}, lanes)};
    } else {  // of 4 bytes: low and high halves of 16
      using Low = std::integer_sequence<int, 0, 4, 1, 5>;
      using High = std::integer_sequence<int, 2, 6, 3, 7>;
      const P xy = mix(r0, r1, Low{}, lanes), xy2 = mix(r2, r3, Low{}, lanes);
      const P zw = mix(r0, r1, High{}, lanes), zw2 = mix(r2, r3, High{}, lanes);
      return {mix(xy, xy2, First{}, lanes), mix(xy, xy2, Last{}, lanes), mix(zw, zw2, First{}, lanes),
              mix(zw, zw2, Last{}, lanes)};
    }
  } else
#endif
  {
    const auto column = [&](int c) { return P::make([&](int l) { return at(l)[c]; }); };
    return {column(0), column(1), column(2), column(3)};
  }
}

}}  // namespace phistep::PHISTEP_ABI
