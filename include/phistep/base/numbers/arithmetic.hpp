/// @file
/// Sizes of numbers, and divisors that stay in range: by powers of two, which change no bit of a result.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Subnormal numbers below it are all rounded alike, and have no finite inverse.
template <class Scalar>
inline constexpr Scalar least_normal = std::numeric_limits<Scalar>::min();

/// x as a divisor for numbers of type Scalar.
template <class Scalar, class Number>
[[nodiscard]] Number at_least_normal(Number x) {
  return std::max(x, static_cast<Number>(least_normal<Scalar>));
}

/// The largest magnitude in a vector or matrix, 0 in an empty one.
template <class Block>
[[nodiscard]] typename Block::Scalar max_abs(const Block& x) {
  return x.size() == 0 ? typename Block::Scalar{0} : x.cwiseAbs().maxCoeff();
}
/// The same as a double.
[[nodiscard]] double largest(const auto& x) { return static_cast<double>(max_abs(x)); }

/// A power of two that brings numbers up to this size to about one, so that their squares stay in range: 1 for 0, and for
/// what is not finite.
template <class Scalar>
[[nodiscard]] Scalar to_unit_size(Scalar size) {
  if (!(size > Scalar{0}) || !std::isfinite(size)) return Scalar{1};
  using Numbers = std::numeric_limits<Scalar>;
  return std::ldexp(Scalar{1}, std::clamp(-std::ilogb(size), Numbers::min_exponent - 1, Numbers::max_exponent - 1));
}

/// The distance from |x| to the next number.
template <class Scalar>
[[nodiscard]] Scalar spacing(Scalar x) {
  return std::nextafter(std::abs(x), std::numeric_limits<Scalar>::infinity()) - std::abs(x);
}

// Random directions and signs, the same on every machine: G. Marsaglia's xorshift (J. Stat. Softw. 8 (2003) 14).

class Xorshift {
 public:
  /// @param seed  not 0
  explicit Xorshift(std::uint64_t seed) : state_{seed} {}
  /// Uniform in [0, 1).
  [[nodiscard]] double number() { return static_cast<double>(next() >> 11) / 9007199254740992.0; }
  /// x or −x
  template <class Scalar>
  [[nodiscard]] Scalar sign(Scalar x) {
    return (next() & 1) != 0 ? x : -x;
  }

 private:
  std::uint64_t next() {
    state_ ^= state_ << 13, state_ ^= state_ >> 7, state_ ^= state_ << 17;
    return state_;
  }
  std::uint64_t state_;
};

}}  // namespace phistep::PHISTEP_ABI
