/// @file
/// Hints to compilers for loops, lambdas and caches.
#pragma once

#include <type_traits>

#include "phistep/core/version.hpp"

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

/// Fetches into the caches what is read a little later. In the user's order, neighbours may be anywhere: with a million in
/// random order, a step of pairs without it takes 1.5 times as long.
inline void prefetch([[maybe_unused]] const void* p) {
#if defined(__GNUC__)
  __builtin_prefetch(p);
#endif
}

}}  // namespace phistep::PHISTEP_ABI
