/// @file
/// The one loop behind every explicit update: write the outputs and find out, in the same pass, whether all are finite.
///
/// 0·x is 0 for a finite x and NaN otherwise, so the sum of 0·x over all outputs is a witness. g++ vectorises eight
/// partial sums but not an integer OR, clang 14 the reverse (design notes, measured); hence two bodies of one idea.
#pragma once

#include <cstddef>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Calls `kernel(i)` for i = 0 … n−1. The kernel writes its outputs and returns Σ 0·output (each times 0 before summing:
/// two large finite outputs must not overflow). Returns false if any output was not finite.
template <class Scalar, class Kernel>
[[nodiscard]] bool update(std::ptrdiff_t n, Kernel kernel) {
#if defined(__clang__)
  unsigned bad = 0;
  for (std::ptrdiff_t i = 0; i < n; ++i) bad |= static_cast<unsigned>(!(kernel(i) == Scalar{0}));
  return bad == 0;
#else
  constexpr std::ptrdiff_t lanes = 8;
  Scalar witness[lanes] = {};
  std::ptrdiff_t i = 0;
  for (; i + lanes <= n; i += lanes)
    for (std::ptrdiff_t j = 0; j < lanes; ++j) witness[j] += kernel(i + j);
  for (; i < n; ++i) witness[0] += kernel(i);
  Scalar sum{0};
  for (const Scalar w : witness) sum += w;
  return sum == Scalar{0};
#endif
}

/// True where every one of the n values is finite.
template <class Scalar>
[[nodiscard]] bool all_finite(const Scalar* x, std::ptrdiff_t n) {
  return update<Scalar>(n, [x](std::ptrdiff_t i) { return Scalar{0} * x[i]; });
}

}  // namespace phistep::inline PHISTEP_ABI
