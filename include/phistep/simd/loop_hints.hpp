/// @file
/// What compilers are told of loops and lambdas, each in its own words.
#pragma once

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
