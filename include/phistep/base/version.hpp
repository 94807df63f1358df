#pragma once

/// @file
/// Version, and the inline namespace that carries it.
///
/// Every header opens `namespace phistep { inline namespace PHISTEP_ABI {`. The name holds the version and the instruction set,
/// because Eigen's alignment and packet sizes follow -march: two units built for different machines would otherwise
/// share one inline function, and the linker would keep whichever it met first. With the name they are different
/// types, so passing a state from one to the other fails at link time instead of at run time. The same holds for units
/// with and without OpenMP, whose loops differ, and without packs (PHISTEP_NO_SIMD).

#define PHISTEP_VERSION_MAJOR 0
#define PHISTEP_VERSION_MINOR 2
#define PHISTEP_VERSION_PATCH 0

// The rest would only repeat these in its own words: the missing header ends it.
#if (defined(_MSVC_LANG) && _MSVC_LANG <= 201703L) || (!defined(_MSVC_LANG) && __cplusplus <= 201703L)
#error "phistep: C++20 is needed: compile with -std=c++20 (MSVC: /std:c++20)"
#include <see the error above>
#endif
#if defined(min) || defined(max)
#error "phistep: min and max are macros here (windows.h): define NOMINMAX before it is included"
#include <see the error above>
#endif
#if !defined(__cpp_exceptions)
#error "phistep: exceptions are needed; compile without -fno-exceptions (a failed step is a return value all the same)"
#include <see the error above>
#endif
// Under -ffast-math or -ffinite-math-only the compiler may delete the checks for NaN and inf on which
// "a failed step leaves the state untouched" rests.
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || defined(_M_FP_FAST)
#error "phistep: -ffast-math removes the NaN checks. Use -O3 -march=native -fno-math-errno -fno-trapping-math"
// g++ tells these two as well, clang doesn't: its users have to know.
#elif defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error \
    "phistep: -funsafe-math-optimizations undoes compensated sums. Use -O3 -march=native -fno-math-errno -fno-trapping-math"
#endif

// g++ 12 and 13 warn of what their own AVX-512 functions leave undefined on purpose (bug 105593), wherever Eigen's loops end
// up. g++ reads the warnings' state here, where those functions are first seen: so this header comes before Eigen.
#if defined(__AVX512F__) && defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>
#pragma GCC diagnostic pop
#endif

// Widest instruction set first; FMA is named because it changes the last bits of a result.
#if defined(__AVX512F__)
#define PHISTEP_DETAIL_ISA avx512
#elif defined(__AVX2__) && defined(__FMA__)
#define PHISTEP_DETAIL_ISA avx2_fma
#elif defined(__AVX2__)
#define PHISTEP_DETAIL_ISA avx2
#elif defined(__AVX__)
#define PHISTEP_DETAIL_ISA avx
#elif defined(__SSE4_2__)
#define PHISTEP_DETAIL_ISA sse4_2
#elif defined(__SSE2__) || defined(_M_X64)
#define PHISTEP_DETAIL_ISA sse2
#elif defined(__ARM_FEATURE_SVE)
#define PHISTEP_DETAIL_ISA sve
#elif defined(__ARM_NEON)
#define PHISTEP_DETAIL_ISA neon
#else
#define PHISTEP_DETAIL_ISA generic
#endif

#ifdef _OPENMP
#define PHISTEP_DETAIL_THREADS _openmp
#else
#define PHISTEP_DETAIL_THREADS
#endif
#ifdef PHISTEP_NO_SIMD
#define PHISTEP_DETAIL_PACKS _no_simd
#else
#define PHISTEP_DETAIL_PACKS
#endif
#define PHISTEP_DETAIL_PASTE(major, minor, isa, packs, threads) v##major##_##minor##_##isa##packs##threads
#define PHISTEP_DETAIL_ABI(major, minor, isa, packs, threads) PHISTEP_DETAIL_PASTE(major, minor, isa, packs, threads)

/// Name of the inline namespace, for example `v0_2_avx2_fma`.
#define PHISTEP_ABI                                                                                          \
  PHISTEP_DETAIL_ABI(PHISTEP_VERSION_MAJOR, PHISTEP_VERSION_MINOR, PHISTEP_DETAIL_ISA, PHISTEP_DETAIL_PACKS, \
                     PHISTEP_DETAIL_THREADS)

namespace phistep { inline namespace PHISTEP_ABI {

/// The version as constants, for `static_assert` and `if constexpr`.
inline constexpr int version_major = PHISTEP_VERSION_MAJOR;
inline constexpr int version_minor = PHISTEP_VERSION_MINOR;
inline constexpr int version_patch = PHISTEP_VERSION_PATCH;

}}  // namespace phistep::PHISTEP_ABI
