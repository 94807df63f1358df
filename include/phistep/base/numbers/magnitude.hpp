/// @file
/// A bound on the magnitude of numbers, at the speed of reading them.
#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>

#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Σ|x|: at least the largest of n magnitudes, not finite where one of them isn't. It may be infinite though all are finite.
///
/// A sum keeps a NaN to the end; a maximum, which costs the same, forgets it. Four sums: one waits for its own last addition.
template <std::floating_point Scalar>
[[nodiscard]] Scalar sum_of_magnitudes(const Scalar* x, std::ptrdiff_t n) {
  using P = Pack<Scalar, native_width<Scalar>>;
  constexpr std::ptrdiff_t width = P::width;
  const auto magnitude = [](P a) {
    if constexpr (detail::in_register<Scalar, P::width>)
      return bitwise(P{Scalar{-0.0}}, a, [](auto sign, auto bits) { return ~sign & bits; });
    else return P::make([a](int l) { return std::abs(a[l]); });
  };
  P a = 0, b = 0, c = 0, d = 0;
  std::ptrdiff_t i = 0;
  for (; i + 4 * width <= n; i += 4 * width) {
    a += magnitude(P::load(x + i));
    b += magnitude(P::load(x + i + width));
    c += magnitude(P::load(x + i + 2 * width));
    d += magnitude(P::load(x + i + 3 * width));
  }
  Scalar rest = 0;
  for (; i < n; ++i) rest += std::abs(x[i]);
  return sum((a + b) + (c + d)) + rest;
}

}}  // namespace phistep::PHISTEP_ABI
