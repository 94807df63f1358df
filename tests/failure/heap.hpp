#pragma once

// A heap that fails at its k-th allocation: operator new by throwing, malloc and its kin, which Eigen calls, by a null
// pointer. Include it in one file of a program, before Eigen.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

#include "support/sanitizers.hpp"

namespace heap {
inline bool armed = false;      // counts, and may fail
inline bool lasting = false;    // fails ever after
inline std::int64_t count = 0;  // allocations since armed
inline std::int64_t fatal = -1;
inline std::int64_t failed = 0;
inline std::int64_t live = 0;    // blocks, always
inline bool news_alone = false;  // malloc and its kin never fail: Eigen 3.4's sparse classes don't survive that

inline bool fails() {
  if (!armed) return false;
  const std::int64_t call = count++;
  const bool bad = fatal >= 0 && (lasting ? call >= fatal : call == fatal);
  failed += bad;
  return bad;
}
inline bool malloc_fails() { return !news_alone && fails(); }
inline void* counted(void* p) {
  live += p != nullptr;
  return p;
}

/// Armed during its life.
struct Armed {
  Armed() { armed = true; }
  ~Armed() { armed = false; }
};
}  // namespace heap

#if defined(PHISTEP_TEST_WRAPS_MALLOC)  // linked with -Wl,--wrap=malloc,…: what this file calls, also under sanitizers
#define PHISTEP_TEST_FAILS_MALLOC 1
#define PHISTEP_TEST_ALLOCATOR(name) __wrap_##name
#define PHISTEP_TEST_NATIVE(name) __real_##name
#elif defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)  // glibc lets a program put itself in front of malloc
#define PHISTEP_TEST_FAILS_MALLOC 1
#define PHISTEP_TEST_ALLOCATOR(name) name
#define PHISTEP_TEST_NATIVE(name) __libc_##name
#else
#define PHISTEP_TEST_FAILS_MALLOC 0
#endif

#if PHISTEP_TEST_FAILS_MALLOC
extern "C" {
void* PHISTEP_TEST_NATIVE(malloc)(std::size_t);
void* PHISTEP_TEST_NATIVE(calloc)(std::size_t, std::size_t);
void* PHISTEP_TEST_NATIVE(realloc)(void*, std::size_t);
void* PHISTEP_TEST_NATIVE(memalign)(std::size_t, std::size_t);
void PHISTEP_TEST_NATIVE(free)(void*);
void* PHISTEP_TEST_ALLOCATOR(malloc)(std::size_t n) noexcept {
  return heap::malloc_fails() ? nullptr : heap::counted(PHISTEP_TEST_NATIVE(malloc)(n));
}
void* PHISTEP_TEST_ALLOCATOR(calloc)(std::size_t n, std::size_t size) noexcept {
  return heap::malloc_fails() ? nullptr : heap::counted(PHISTEP_TEST_NATIVE(calloc)(n, size));
}
void* PHISTEP_TEST_ALLOCATOR(realloc)(void* p, std::size_t n) noexcept {
  if (heap::malloc_fails()) return nullptr;
  void* const moved = PHISTEP_TEST_NATIVE(realloc)(p, n);
  heap::live += p == nullptr && moved != nullptr;
  return moved;
}
void* PHISTEP_TEST_ALLOCATOR(memalign)(std::size_t alignment, std::size_t n) noexcept {
  return heap::malloc_fails() ? nullptr : heap::counted(PHISTEP_TEST_NATIVE(memalign)(alignment, n));
}
void* PHISTEP_TEST_ALLOCATOR(aligned_alloc)(std::size_t alignment, std::size_t n) noexcept {
  return heap::malloc_fails() ? nullptr : heap::counted(PHISTEP_TEST_NATIVE(memalign)(alignment, n));
}
int PHISTEP_TEST_ALLOCATOR(posix_memalign)(void** p, std::size_t alignment, std::size_t n) noexcept {
  *p = heap::malloc_fails() ? nullptr : heap::counted(PHISTEP_TEST_NATIVE(memalign)(alignment, n));
  return *p == nullptr ? 12 : 0;  // ENOMEM
}
void PHISTEP_TEST_ALLOCATOR(free)(void* p) noexcept {
  heap::live -= p != nullptr;
  PHISTEP_TEST_NATIVE(free)(p);
}
}
#endif

namespace heap {
inline void* take(std::size_t n) {
#if PHISTEP_TEST_FAILS_MALLOC
  return fails() ? nullptr : counted(PHISTEP_TEST_NATIVE(malloc)(n > 0 ? n : 1));
#else
  return fails() ? nullptr : counted(std::malloc(n > 0 ? n : 1));
#endif
}
inline void give(void* p) {
  live -= p != nullptr;
#if PHISTEP_TEST_FAILS_MALLOC
  PHISTEP_TEST_NATIVE(free)(p);
#else
  std::free(p);
#endif
}
}  // namespace heap
void* operator new(std::size_t n) {
  if (void* p = heap::take(n)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t n, const std::nothrow_t&) noexcept { return heap::take(n); }
void operator delete(void* p) noexcept { heap::give(p); }
void operator delete(void* p, std::size_t) noexcept { heap::give(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { heap::give(p); }
