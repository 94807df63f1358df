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
#include "phistep/base/version.hpp"

#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__SSE2__) || defined(_M_X64)
#include <emmintrin.h>
#endif

namespace phistep { inline namespace PHISTEP_ABI {
namespace detail {

// The same on as many words as a register holds: the compilers' own vectorisation misses the 32×32→64 multiply.
#if defined(__AVX512F__)
struct Words {
  static constexpr std::ptrdiff_t count = 8;
  using Register = __m512i;
  static Register load(const void* p) { return _mm512_loadu_si512(p); }
  static void store(void* p, Register x) { _mm512_storeu_si512(p, x); }
  static Register spread(std::uint64_t x) { return _mm512_set1_epi64(static_cast<long long>(x)); }
  static Register add(Register a, Register b) { return _mm512_add_epi64(a, b); }
  // Masked by all ones, which costs nothing: g++ 12 warns about its own plain forms (uninitialised __Y).
  static Register halves(Register z) { return _mm512_maskz_mul_epu32(0xff, z, _mm512_maskz_srli_epi64(0xff, z, 32)); }
};
#elif defined(__AVX2__)
struct Words {
  static constexpr std::ptrdiff_t count = 4;
  using Register = __m256i;
  static Register load(const void* p) { return _mm256_loadu_si256(static_cast<const __m256i*>(p)); }
  static void store(void* p, Register x) { _mm256_storeu_si256(static_cast<__m256i*>(p), x); }
  static Register spread(std::uint64_t x) { return _mm256_set1_epi64x(static_cast<long long>(x)); }
  static Register add(Register a, Register b) { return _mm256_add_epi64(a, b); }
  static Register halves(Register z) { return _mm256_mul_epu32(z, _mm256_srli_epi64(z, 32)); }
};
#elif defined(__SSE2__) || defined(_M_X64)
struct Words {
  static constexpr std::ptrdiff_t count = 2;
  using Register = __m128i;
  static Register load(const void* p) { return _mm_loadu_si128(static_cast<const __m128i*>(p)); }
  static void store(void* p, Register x) { _mm_storeu_si128(static_cast<__m128i*>(p), x); }
  static Register spread(std::uint64_t x) { return _mm_set1_epi64x(static_cast<long long>(x)); }
  static Register add(Register a, Register b) { return _mm_add_epi64(a, b); }
  static Register halves(Register z) { return _mm_mul_epu32(z, _mm_srli_epi64(z, 32)); }
};
#else
struct Words {
  static constexpr std::ptrdiff_t count = 1;
  using Register = std::uint64_t;
  static Register load(const void* p) {
    Register x;
    std::memcpy(&x, p, 8);
    return x;
  }
  static void store(void* p, Register x) { std::memcpy(p, &x, 8); }
  static Register spread(std::uint64_t x) { return x; }
  static Register add(Register a, Register b) { return a + b; }
  static Register halves(Register z) { return (z & 0xffffffffu) * (z >> 32); }
};
#endif

}  // namespace detail

/// Of word i.
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
      sum_[u] = Words::spread(0);
    }
  }

  void add(const void* data, std::ptrdiff_t bytes) {
    const auto* p = static_cast<const unsigned char*>(data);
    const auto stride = Words::spread(static_cast<std::uint64_t>(unroll * Words::count) * phi);
    for (; bytes >= granule; bytes -= granule, p += granule) accumulate(p, stride);
    // The last piece's rest, a register and then a word at a time: the same for every width.
    if constexpr (Words::count > 1)
      for (int u = 0; bytes >= 8 * Words::count; ++u, bytes -= 8 * Words::count, p += 8 * Words::count) {
        sum_[u] = Words::add(sum_[u], Words::halves(Words::add(Words::load(p), key_[u])));
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
      Words::store(lane, sum);
      for (const std::uint64_t x : lane) total += x;
    }
    return total;
  }

 private:
  void accumulate(const unsigned char* p, Words::Register stride) {
    for (std::ptrdiff_t u = 0; u < unroll; ++u) {
      sum_[u] = Words::add(sum_[u], Words::halves(Words::add(Words::load(p + 8 * u * Words::count), key_[u])));
      key_[u] = Words::add(key_[u], stride);
    }
    words_ += unroll * Words::count;
  }

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

/// Of n numbers, by their bits and their order, on top of what was seen before (`seed`).
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
    Fingerprint all;
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      std::uint64_t words[2] = {0, 0};
      std::memcpy(words, x + i, number_bytes<Scalar>);
      for (const std::uint64_t& word : words) all.add(&word, 8);
    }
    return seed * phi + all.value();
  }
}

}}  // namespace phistep::PHISTEP_ABI
