/// @file
/// Hints for loops: to compilers, each in its own words, and to the caches.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <type_traits>
#if (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__)
#include <cpuid.h>
#endif

#include "phistep/base/version.hpp"

/// After the parameters of a lambda.
#if defined(__GNUC__)
#define PHISTEP_DETAIL_INLINED __attribute__((always_inline))
#else
#define PHISTEP_DETAIL_INLINED
#endif

/// Before a loop: no iteration reads what another one writes. It spares the run-time overlap tests, which an output that
/// is an input would fail. clang warns where it can't obey, as under its sanitizers, which don't need the speed.
#if defined(__clang__)
#if __has_feature(address_sanitizer) || __has_feature(undefined_behavior_sanitizer) || \
    __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define PHISTEP_DETAIL_ELEMENTWISE
#else
#define PHISTEP_DETAIL_ELEMENTWISE _Pragma("clang loop vectorize(assume_safety)")
#endif
#elif defined(__GNUC__)
#define PHISTEP_DETAIL_ELEMENTWISE _Pragma("GCC ivdep")
#elif defined(_MSC_VER)
#define PHISTEP_DETAIL_ELEMENTWISE __pragma(loop(ivdep))
#else
#define PHISTEP_DETAIL_ELEMENTWISE
#endif

/// An OpenMP directive; nothing where the compiler has none.
#ifdef _OPENMP
#define PHISTEP_DETAIL_OMP(directive) _Pragma(directive)
#else
#define PHISTEP_DETAIL_OMP(directive)
#endif

namespace phistep { inline namespace PHISTEP_ABI {

/// f(0), f(1) … f(n − 1) with constants for arguments, so that arrays of packs stay in registers: at -O2 g++ 12 leaves
/// `for (int a = 0; a < 3; ++a)` a loop, and what it indexes in memory.
template <int n, int k = 0, class F>
[[gnu::always_inline]] constexpr void unrolled(F&& f) {
  if constexpr (k < n) {
    f(std::integral_constant<int, k>{});
    unrolled<n, k + 1>(f);
  }
}

/// Fetches into the caches what is read a little later. A particle's neighbours may lie anywhere in memory: with a million
/// particles in random order, a step with pair forces takes 1.5 times as long without it.
inline void prefetch([[maybe_unused]] const void* p) {
#if defined(__GNUC__)
  __builtin_prefetch(p);
#endif
}

/// [bytes] Size of the last-level cache that this core reaches; 32 MiB where the processor doesn't tell.
///
/// Asked of the processor itself: sysconf(_SC_LEVEL3_CACHE_SIZE) of glibc 2.36 answers 320 MiB on an EPYC of ten times 32,
/// where a core reaches one of them.
[[nodiscard]] inline std::ptrdiff_t last_cache() {
  static const std::ptrdiff_t size = [] {
    std::ptrdiff_t largest = 0;
#if (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__)
    // Intel's leaf of caches and AMD's: the same fields, one cache a subleaf; a processor knows one of them.
    for (const unsigned leaf : {0x4u, 0x8000001du})
      for (unsigned cache = 0; cache < 8; ++cache) {
        unsigned a = 0, b = 0, c = 0, d = 0;
        if (__get_cpuid_count(leaf, cache, &a, &b, &c, &d) == 0 || (a & 0x1f) == 0) break;
        const auto field = [](unsigned word, int from, unsigned mask) {
          return static_cast<std::ptrdiff_t>((word >> from) & mask) + 1;
        };
        const std::ptrdiff_t ways = field(b, 22, 0x3ff), partitions = field(b, 12, 0x3ff), line = field(b, 0, 0xfff);
        const std::ptrdiff_t bytes = ways * partitions * line * (static_cast<std::ptrdiff_t>(c) + 1);
        if (bytes > largest) largest = bytes;
      }
#endif
    return largest > 0 ? largest : std::ptrdiff_t{32} << 20;
  }();
  return size;
}

}}  // namespace phistep::PHISTEP_ABI
