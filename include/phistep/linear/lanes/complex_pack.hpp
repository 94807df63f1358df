/// @file
/// Packs wider than a register, and complex numbers side by side.
#pragma once

#include <type_traits>

#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Two packs as one.
template <class Half>
struct PackPair {
  using Scalar = typename Half::Scalar;
  static constexpr int width = 2 * Half::width;
  Half low, high;
  PackPair() = default;
  PackPair(Half l, Half h) : low{l}, high{h} {}
  explicit PackPair(Scalar x) : low{x}, high{x} {}
  [[nodiscard]] static PackPair load(const Scalar* p) { return {Half::load(p), Half::load(p + Half::width)}; }
  void store(Scalar* p) const {
    low.store(p);
    high.store(p + Half::width);
  }
  [[nodiscard]] Scalar operator[](int l) const { return l < Half::width ? low[l] : high[l - Half::width]; }
  [[nodiscard]] friend PackPair operator+(const PackPair& a, const PackPair& b) {
    return {a.low + b.low, a.high + b.high};
  }
  [[nodiscard]] friend PackPair operator-(const PackPair& a, const PackPair& b) {
    return {a.low - b.low, a.high - b.high};
  }
  [[nodiscard]] friend PackPair operator*(const PackPair& a, const PackPair& b) {
    return {a.low * b.low, a.high * b.high};
  }
  [[nodiscard]] friend PackPair operator/(const PackPair& a, const PackPair& b) {
    return {a.low / b.low, a.high / b.high};
  }
  [[nodiscard]] PackPair operator-() const { return {-low, -high}; }
  [[nodiscard]] friend Scalar sum(const PackPair& a) { return sum(a.low + a.high); }
  [[nodiscard]] friend PackPair larger(const PackPair& a, const PackPair& b) {
    return {larger(a.low, b.low), larger(a.high, b.high)};
  }
  [[nodiscard]] friend bool all_at_least(const PackPair& a, const PackPair& b) {
    return all_at_least(a.low, b.low) && all_at_least(a.high, b.high);
  }
};
/// False for NaN.
template <class Scalar, int width>
[[nodiscard]] bool all_at_least(Pack<Scalar, width> a, Pack<Scalar, width> b) {
  return all(a >= b);
}

/// `width` numbers in one register, or in two of half its size.
template <class Scalar, int width>
using WidePack = std::conditional_t<native_width<Scalar> == 1 || native_width<Scalar> >= width, Pack<Scalar, width>,
                                    PackPair<Pack<Scalar, width / 2>>>;

/// A complex number a lane.
template <class Scalar, int lanes>
struct ComplexPack {
  using Real = WidePack<Scalar, lanes>;
  Real re, im;
  [[nodiscard]] friend ComplexPack operator*(const ComplexPack& a, const ComplexPack& b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
  }
  /// this −= a b
  void subtract(const ComplexPack& a, const ComplexPack& b) {
    re = re - a.re * b.re;
    im = im - a.re * b.im;
    re = re + a.im * b.im;
    im = im - a.im * b.re;
  }
  void add(const ComplexPack& a, const ComplexPack& b) {
    re = re + a.re * b.re;
    im = im + a.re * b.im;
    re = re - a.im * b.im;
    im = im + a.im * b.re;
  }
  [[nodiscard]] Real norm() const { return re * re + im * im; }
  [[nodiscard]] ComplexPack inverse() const {
    const Real by = Real{Scalar{1}} / norm();
    return {re * by, -(im * by)};
  }
};

}}  // namespace phistep::PHISTEP_ABI
