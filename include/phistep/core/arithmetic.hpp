/// @file
/// The guarded update: write arrays elementwise and learn, from the same pass, whether every number written is finite.
///
///     bool finite = update(n, [=](Index i, double& r1, double& v1) { v1 = …; r1 = …; }, r_next, v_next);
///
/// A step writes beside the old state and commits by swap: on `false` nothing of the old state has been touched.
/// Why it looks as it does (measured, g++ 12 and clang 14, SSE2 to AVX-512, 1e3 to 1e6 particles):
///  · The witness is an OR over the bits of x − x: ±0 where x is finite, NaN otherwise. Integer OR may be reordered, so
///    both compilers vectorise it; a floating-point sum they may not. It costs no time beside the memory traffic.
///  · In cache the price is the number of lines fetched: 3 inputs + 2 outputs against 3 for the loop in place. An output
///    may be the very array of an input (v⁺ over a Ψ that nobody needs any more), and is then fetched once.
///  · Beyond the caches an ordinary store first reads the line it overwrites; a streaming store doesn't, so that writing
///    beside the state moves no more bytes than the loop in place. Compilers emit none by themselves: the same
///    vectorised loop fills a block in L1, which is then streamed out.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "phistep/core/version.hpp"

#if defined(__SSE2__) || defined(_M_X64)
#include <emmintrin.h>
#define PHISTEP_DETAIL_STREAMS 1
#else
#define PHISTEP_DETAIL_STREAMS 0
#endif

/// Before a loop: no iteration reads what another one writes. It spares the run-time overlap tests, which an output that
/// is an input would fail.
#if defined(__clang__)
#define PHISTEP_DETAIL_ELEMENTWISE _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define PHISTEP_DETAIL_ELEMENTWISE _Pragma("GCC ivdep")
#elif defined(_MSC_VER)
#define PHISTEP_DETAIL_ELEMENTWISE __pragma(loop(ivdep))
#else
#define PHISTEP_DETAIL_ELEMENTWISE
#endif

namespace phistep::inline PHISTEP_ABI {

/// Remembers whether all numbers seen were finite.
template <std::floating_point Scalar>
class FiniteWitness {
  static constexpr bool bitwise = sizeof(Scalar) == 4 || sizeof(Scalar) == 8;  // long double has padding, and no SIMD
  using Bits = std::conditional_t<sizeof(Scalar) == 4, std::uint32_t, std::uint64_t>;

 public:
  void see(Scalar x) {
    if constexpr (bitwise) seen_ |= std::bit_cast<Bits>(x - x);
    else seen_ |= x - x == 0 ? 0u : 2u;
  }
  void see(FiniteWitness other) { seen_ |= other.seen_; }
  /// The sign bit doesn't count: x − x is −0 when rounding towards −∞.
  [[nodiscard]] bool all_finite() const { return static_cast<Bits>(seen_ << 1) == 0; }

 private:
  Bits seen_ = 0;
};

/// [bytes] Size of one array from which outputs bypass the caches: the arrays of a step no longer fit them.
inline constexpr std::ptrdiff_t stream_from = std::ptrdiff_t{4} << 20;

namespace detail {

/// to[i] = kernel's outputs for begin + i. They pass through locals, so that a kernel may write one output before it
/// reads an input of the same i, though both be one array.
template <class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
[[nodiscard]] FiniteWitness<Scalar> fill(std::ptrdiff_t begin, std::ptrdiff_t count, Kernel kernel, Scalar* to,
                                         Scalars*... more) {
  FiniteWitness<Scalar> witness;
  PHISTEP_DETAIL_ELEMENTWISE
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    [&](Scalar x, Scalars... y) {
      kernel(begin + i, x, y...);
      to[i] = x;
      ((more[i] = y), ...);
      witness.see(x);
      (witness.see(y), ...);
    }(Scalar{}, Scalars{}...);
  }
  return witness;
}

inline constexpr std::ptrdiff_t stream_block = 512;  // bytes: 8 cache lines; 2 … 16 do as well, 64 overlap badly

#if PHISTEP_DETAIL_STREAMS
inline bool is_packet_aligned(const void* p) { return reinterpret_cast<std::uintptr_t>(p) % sizeof(__m128i) == 0; }

/// Copies one block past the caches. 16 bytes a store: the write-combining buffers join them to lines.
inline void stream(void* to, const void* from) {
  auto* const out = static_cast<__m128i*>(to);
  const auto* const in = static_cast<const __m128i*>(from);
  for (std::size_t k = 0; k < stream_block / sizeof(__m128i); ++k) _mm_stream_si128(out + k, _mm_load_si128(in + k));
}

/// `update` with streaming stores. All outputs must sit on 16 bytes.
template <class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
[[nodiscard]] bool update_streaming(std::ptrdiff_t n, Kernel kernel, Scalar* out, Scalars*... more) {
  constexpr std::ptrdiff_t length = stream_block / static_cast<std::ptrdiff_t>(sizeof(Scalar));
  alignas(64) Scalar block[1 + sizeof...(more)][length];
  Scalar* const to[] = {out, more...};
  FiniteWitness<Scalar> witness;
  std::ptrdiff_t i = 0;
  [&]<std::size_t... k>(std::index_sequence<k...>) {
    for (; i + length <= n; i += length) {
      witness.see(fill(i, length, kernel, block[k]...));
      (stream(to[k] + i, block[k]), ...);
    }
    _mm_sfence();  // streamed stores are ordered with nothing: another thread may read the result next
    witness.see(fill(i, n - i, kernel, (to[k] + i)...));
  }(std::make_index_sequence<1 + sizeof...(more)>{});
  return witness.all_finite();
}
#endif
}  // namespace detail

/// `update` for the few numbers of a small fixed state, known at compile time and unrolled: it stays in registers.
template <std::ptrdiff_t n, class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
[[nodiscard]] bool update_unrolled(Kernel kernel, Scalar* out, Scalars*... more) {
  // A sum of 0·x beats the bit test here: one dependent chain less, and no move between register files.
  Scalar witness{0};
  const auto one = [&](std::ptrdiff_t i, Scalar x, Scalars... y) {
    kernel(i, x, y...);
    out[i] = x;
    ((more[i] = y), ...);
    witness += Scalar{0} * x;
    ((witness += Scalar{0} * y), ...);
  };
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (one(static_cast<std::ptrdiff_t>(i), Scalar{}, Scalars{}...), ...);
  }(std::make_index_sequence<static_cast<std::size_t>(n)>{});
  return witness == Scalar{0};
}

/// kernel(i, x…) sets each x from the inputs at i alone; out…[i] = x…, for 0 ≤ i < n. Returns whether all are finite.
/// An output may be an input of the kernel, as a whole; it may not overlap one otherwise.
template <class Kernel, class Scalar, std::same_as<Scalar>... Scalars>
[[nodiscard]] bool update(std::ptrdiff_t n, Kernel kernel, Scalar* out, Scalars*... more) {
#if PHISTEP_DETAIL_STREAMS
  constexpr auto size = static_cast<std::ptrdiff_t>(sizeof(Scalar));
  if constexpr (size == 4 || size == 8)
    if (n >= stream_from / size && detail::is_packet_aligned(out) && (detail::is_packet_aligned(more) && ...))
      return detail::update_streaming(n, kernel, out, more...);
#endif
  return detail::fill(0, n, kernel, out, more...).all_finite();
}

/// True where every one of the n values is finite.
template <class Scalar>
[[nodiscard]] bool all_finite(const Scalar* x, std::ptrdiff_t n) {
  FiniteWitness<Scalar> witness;
  for (std::ptrdiff_t i = 0; i < n; ++i) witness.see(x[i]);
  return witness.all_finite();
}

}  // namespace phistep::inline PHISTEP_ABI
