/// @file
/// A 64-bit fingerprint of an array: detects edits of the state between two steps.
///
///     Σᵢ lo(zᵢ) · hi(zᵢ) mod 2⁶⁴,   zᵢ = wordᵢ + (i+1)·φ,   lo and hi: the 32-bit halves, φ = 2⁶⁴/golden ratio
///
/// This is NH, the inner hash of UMAC (Black et al., CRYPTO 1999), with keys that count instead of a key table: about
/// 2⁻³² of all edits pass unseen, and swaps of unequal numbers are seen because each place has its own key. It suits the
/// job because one 32×32→64 multiply is the only one that SSE2 has, and because a sum may be taken in any order: every
/// vector width gives the same value, and a pass over blocks the value of a pass over the whole.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "phistep/base/machine/shares.hpp"

#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace phistep { inline namespace PHISTEP_ABI {
namespace detail {

// The words that a register holds.
struct Words {
#if defined(__GNUC__) && defined(__SSE2__)
#if defined(__AVX512F__)
  static constexpr std::ptrdiff_t count = 8;
#elif defined(__AVX2__)
  static constexpr std::ptrdiff_t count = 4;
#else
  static constexpr std::ptrdiff_t count = 2;
#endif
  typedef std::uint64_t Register __attribute__((vector_size(8 * count)));
#else
  static constexpr std::ptrdiff_t count = 1;
  using Register = std::uint64_t;
#endif
  static Register load(const void* p) {
    Register x;
    std::memcpy(&x, p, sizeof x);
    return x;
  }
  /// lo(z) hi(z): the compilers' own vectorization misses the 32×32→64 multiply.
  static Register halves(Register z) {
    const Register high = z >> 32;
#if defined(__GNUC__) && defined(__AVX512F__)
    // Masked by all ones, which costs nothing: g++ 12 warns about its own plain form (uninitialised __Y).
    return reinterpret_cast<Register>(
        _mm512_maskz_mul_epu32(0xff, reinterpret_cast<__m512i>(z), reinterpret_cast<__m512i>(high)));
#elif defined(__GNUC__) && defined(__AVX2__)
    return reinterpret_cast<Register>(_mm256_mul_epu32(reinterpret_cast<__m256i>(z), reinterpret_cast<__m256i>(high)));
#elif defined(__GNUC__) && defined(__SSE2__)
    return reinterpret_cast<Register>(_mm_mul_epu32(reinterpret_cast<__m128i>(z), reinterpret_cast<__m128i>(high)));
#else
    return (z & 0xffffffffu) * high;
#endif
  }
};

}  // namespace detail

/// What word i adds.
[[nodiscard]] inline std::uint64_t fingerprint_term(std::uint64_t word, std::uint64_t i) {
  const std::uint64_t z = word + (i + 1) * 0x9e3779b97f4a7c15u;
  return (z & 0xffffffffu) * (z >> 32);
}

/// Takes an array piece by piece, so that it can ride on a loop that has the piece in L1 anyway.
class Fingerprint {
  using Words = detail::Words;
  static constexpr std::ptrdiff_t unroll = 4;  // hides the latency of the multiply
  static constexpr std::uint64_t phi = 0x9e3779b97f4a7c15u;

 public:
  /// [bytes] Every piece but the last must be a multiple of this.
  static constexpr std::ptrdiff_t granule = 8 * unroll * Words::count;

  /// @param words  that stand before what will be added, a multiple of granule / 8
  explicit Fingerprint(std::uint64_t words = 0) : words_{words} {
    std::uint64_t keys[unroll * Words::count];
    for (std::uint64_t i = 0; i < unroll * Words::count; ++i) keys[i] = (words + i + 1) * phi;
    for (std::ptrdiff_t u = 0; u < unroll; ++u) {
      key_[u] = Words::load(keys + u * Words::count);
      sum_[u] = Words::Register{};
    }
  }

  void add(const void* data, std::ptrdiff_t bytes) {
    const auto* p = static_cast<const unsigned char*>(data);
    const auto stride = Words::Register{} + static_cast<std::uint64_t>(unroll * Words::count) * phi;
    for (; bytes >= granule; bytes -= granule, p += granule) {
      for (std::ptrdiff_t u = 0; u < unroll; ++u) {
        sum_[u] += Words::halves(Words::load(p + 8 * u * Words::count) + key_[u]);
        key_[u] += stride;
      }
      words_ += unroll * Words::count;
    }
    // The last piece's rest, a register and then a word at a time: the same for every width.
    if constexpr (Words::count > 1)
      for (int u = 0; bytes >= 8 * Words::count; ++u, bytes -= 8 * Words::count, p += 8 * Words::count) {
        sum_[u] += Words::halves(Words::load(p) + key_[u]);
        words_ += Words::count;
      }
    for (; bytes > 0; bytes -= 8, p += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, p, bytes < 8 ? static_cast<std::size_t>(bytes) : 8);
      rest_ += fingerprint_term(word, words_++);
    }
  }

  [[nodiscard]] std::uint64_t value() const {
    std::uint64_t lane[Words::count], total = rest_;
    for (const auto& sum : sum_) {
      std::memcpy(lane, &sum, sizeof sum);
      for (const std::uint64_t x : lane) total += x;
    }
    return total;
  }

 private:
  Words::Register key_[unroll], sum_[unroll];
  std::uint64_t words_, rest_ = 0;
};

/// [bytes] that hold a number: an x87 long double has 10, and padding that is never set; others (16 bytes) have none.
template <class Scalar>
inline constexpr std::size_t number_bytes = sizeof(Scalar) > 8 && std::numeric_limits<Scalar>::digits == 64
                                                ? 10
                                                : sizeof(Scalar);

/// Whether n numbers are the same by their bits: −0 is not +0, and a NaN is itself.
template <class Scalar>
[[nodiscard]] bool same_bits(const Scalar* a, const Scalar* b, std::ptrdiff_t n) {
  if constexpr (number_bytes<Scalar> == sizeof(Scalar)) {
    return n == 0 || std::memcmp(a, b, static_cast<std::size_t>(n) * sizeof(Scalar)) == 0;
  } else {
    for (std::ptrdiff_t i = 0; i < n; ++i)
      if (std::memcmp(a + i, b + i, number_bytes<Scalar>) != 0) return false;
    return true;
  }
}

/// What n numbers add to the fingerprint of an array (seed 0) where they stand from number `first` on. Of numbers of less than
/// 8 bytes, two of which share a word, a fingerprint of its own.
template <class Scalar>
[[nodiscard]] std::uint64_t fingerprint_of_some(const Scalar* x, std::ptrdiff_t n, std::ptrdiff_t first) {
  constexpr std::size_t words = (sizeof(Scalar) + 7) / 8;
  std::uint64_t sum = 0;
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    std::uint64_t word[words] = {};
    std::memcpy(word, x + i, number_bytes<Scalar>);
    for (std::size_t w = 0; w < words; ++w)
      sum += fingerprint_term(word[w], static_cast<std::uint64_t>(first + i) * words + w);
  }
  return sum;
}

/// The fingerprint of n numbers, by their bits and their order, on top of what was seen before (`seed`).
template <class Scalar>
[[nodiscard]] std::uint64_t fingerprint(const Scalar* x, std::ptrdiff_t n, std::uint64_t seed = 0) {
  constexpr std::uint64_t phi = 0x9e3779b97f4a7c15u;
  if constexpr (sizeof(Scalar) <= 8) {
    constexpr std::ptrdiff_t size = sizeof(Scalar);
    std::atomic<std::uint64_t> sum = 0;
    for_each_range(n, Fingerprint::granule / size, [&](std::ptrdiff_t first, std::ptrdiff_t end) {
      Fingerprint part(static_cast<std::uint64_t>(first * size / 8));
      part.add(x + first, (end - first) * size);
      sum += part.value();
    });
    return seed * phi + sum;
  } else {
    return seed * phi + fingerprint_of_some(x, n, 0);
  }
}

}}  // namespace phistep::PHISTEP_ABI
