/// @file
/// A 64-bit fingerprint of an array: tells whether the user edited the state between two steps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Order-sensitive hash of n numbers by their bits, mixed in word by word.
template <class Scalar>
[[nodiscard]] std::uint64_t fingerprint(const Scalar* x, std::ptrdiff_t n, std::uint64_t seed = 0) {
  std::uint64_t hash = seed ^ 0x9e3779b97f4a7c15u;
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    std::uint64_t word = 0;
    std::memcpy(&word, x + i, sizeof(Scalar) < 8 ? sizeof(Scalar) : 8);
    hash = (hash ^ word) * 0xff51afd7ed558ccdu;
    hash ^= hash >> 32;
  }
  return hash;
}

}  // namespace phistep::inline PHISTEP_ABI
