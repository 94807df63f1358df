/// @file
/// Packs wider than a register, and complex numbers side by side, with what eliminations ask of them (banded_lu.hpp).
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <type_traits>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/numbers/pack_math.hpp"

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
  [[nodiscard]] friend PackPair operator+(PackPair a, PackPair b) { return {a.low + b.low, a.high + b.high}; }
  [[nodiscard]] friend PackPair operator-(PackPair a, PackPair b) { return {a.low - b.low, a.high - b.high}; }
  [[nodiscard]] friend PackPair operator*(PackPair a, PackPair b) { return {a.low * b.low, a.high * b.high}; }
  [[nodiscard]] friend PackPair operator/(PackPair a, PackPair b) { return {a.low / b.low, a.high / b.high}; }
  [[nodiscard]] PackPair operator-() const { return {-low, -high}; }
  [[nodiscard]] friend Scalar sum(PackPair a) { return sum(a.low + a.high); }
  [[nodiscard]] friend PackPair larger(PackPair a, PackPair b) {
    return {larger(a.low, b.low), larger(a.high, b.high)};
  }
  [[nodiscard]] friend bool all_at_least(PackPair a, PackPair b) {
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
  [[nodiscard]] Real norm() const { return re * re + im * im; }
};
/// to −= a b
template <class Scalar, int lanes>
void subtract_product(ComplexPack<Scalar, lanes>& to, const ComplexPack<Scalar, lanes>& a,
                      const ComplexPack<Scalar, lanes>& b) {
  const auto re = to.re - a.re * b.re, im = to.im - a.re * b.im;
  to = {re + a.im * b.im, im - a.im * b.re};
}
/// Small Jacobians are mostly zeros.
template <class Scalar, int lanes>
[[nodiscard]] bool is_known_zero(const ComplexPack<Scalar, lanes>& x) {
  return x.re[0] == Scalar{0} && all_at_least(typename ComplexPack<Scalar, lanes>::Real{Scalar{0}}, x.norm());
}
/// x ← 1/x. False where a lane is zero, not finite, or has a square that leaves the range.
template <class Scalar, int lanes>
[[nodiscard]] bool invert(ComplexPack<Scalar, lanes>& x) {
  using Real = typename ComplexPack<Scalar, lanes>::Real;
  const Real size = x.norm(), by = Real{Scalar{1}} / size;
  x = {x.re * by, -(x.im * by)};
  return all_at_least(size, Real{least_normal<Scalar>}) && all_at_least(Real{std::numeric_limits<Scalar>::max()}, size);
}

/// What pivots are compared by: |x|, of complex numbers its square.
template <std::floating_point Scalar>
[[nodiscard]] Pack<Scalar, 1> size_of(Scalar x) {
  return Pack<Scalar, 1>{std::abs(x)};
}
template <class Scalar, int lanes>
[[nodiscard]] auto size_of(const ComplexPack<Scalar, lanes>& x) {
  return x.norm();
}
template <class Number>
using Size = decltype(size_of(Number{}));

/// Multipliers up to 8 are trusted, and up to 2 where no iteration need follow; `times` as large ones (threshold pivoting, I. S. Duff,
/// A. M. Erisman & J. K. Reid, Direct Methods for Sparse Matrices, sect. 5.2): a row in its place spares fill.
/// @param largest  of what is beside the pivot
template <int times = 1, class Number>
[[nodiscard]] bool is_trusted(const Number& pivot, const Size<Number>& largest) {
  constexpr int most = std::floating_point<Number> ? 2 * times : 64 * times * times;
  return all_at_least(size_of(pivot) * Size<Number>{most}, largest);
}
/// The row of a column that is to be the pivot's, in all lanes: of at(0) … at(count − 1) the first, where no lane's
/// multipliers are too large with it; else the one whose worst lane is best beside that lane's largest entry. Lanes are
/// matrices λ_l M − J of one method, whose entries are alike in size.
template <class Number, class Count>
[[nodiscard]] Count threshold_pivot(Count count, auto&& at) {
  Size<Number> best = size_of(at(Count{0}));
  for (Count i = 1; i < count; ++i) best = larger(size_of(at(i)), best);
  if (is_trusted(at(Count{0}), best)) return Count{0};
  // 0 and NaN are found by invert().
  const Size<Number> by = Size<Number>{1} / best;
  Count chosen{0};
  double share = -1;
  for (Count i = 0; i < count; ++i) {
    const Size<Number> x = size_of(at(i)) * by;
    double worst = static_cast<double>(x[0]);
    for (int l = 1; l < Size<Number>::width; ++l) worst = std::min(worst, static_cast<double>(x[l]));
    if (worst > share) share = worst, chosen = i;
  }
  return chosen;
}
template <class Scalar, int lanes>
[[nodiscard]] Eigen::Index pivot_row(const ComplexPack<Scalar, lanes>* column, Eigen::Index rows) {
  return threshold_pivot<ComplexPack<Scalar, lanes>>(
      rows, [column](Eigen::Index d) -> auto& { return column[d]; });
}

}}  // namespace phistep::PHISTEP_ABI
