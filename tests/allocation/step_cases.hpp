#pragma once

// Counts every allocation that Eigen or the library could make. Included first, by one file of a program: it replaces
// malloc.

#ifndef EIGEN_RUNTIME_NO_MALLOC
#error "define EIGEN_RUNTIME_NO_MALLOC: a second, independent witness, Eigen asserts where it allocates"
#endif

#include <phistep/sparse.hpp>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <new>

#include "contract/states.hpp"
#include "support/catch.hpp"
#include "support/sanitizers.hpp"

namespace heap {
// Counting is on for the duration of a step alone.
inline bool counting = false;
inline std::int64_t count = 0;
}  // namespace heap

// Eigen allocates by malloc, posix_memalign or the like, everything else by new. glibc lets a program put itself in front of
// malloc; elsewhere new alone is counted, and Eigen's own check (below) stands in for malloc.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define PHISTEP_TEST_COUNTS_MALLOC 1
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void* malloc(std::size_t n) noexcept {
  heap::count += heap::counting;
  return __libc_malloc(n);
}
void* calloc(std::size_t n, std::size_t size) noexcept {
  heap::count += heap::counting;
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t n) noexcept {
  heap::count += heap::counting;
  return __libc_realloc(p, n);
}
void* aligned_alloc(std::size_t alignment, std::size_t n) noexcept {
  heap::count += heap::counting;
  return __libc_memalign(alignment, n);
}
int posix_memalign(void** p, std::size_t alignment, std::size_t n) noexcept {
  heap::count += heap::counting;
  *p = __libc_memalign(alignment, n);
  return *p == nullptr;
}
}
#else
#define PHISTEP_TEST_COUNTS_MALLOC 0
void* operator new(std::size_t n) {
  heap::count += heap::counting;
  if (void* p = std::malloc(n)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t n, const std::nothrow_t&) noexcept {
  heap::count += heap::counting;
  return std::malloc(n);
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
#endif

using namespace phistep;
using states::Dynamic;

namespace {

/// Accumulates, and allocates nothing. Nonlinear enough that the Jacobian is renewed in every step.
struct Chain : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  static void add_to(const auto& x, auto& f) {
    const Eigen::Index n = x.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto left = i > 0 ? x.data()[i - 1] - x.data()[i] : -x.data()[i];
      const auto right = i + 1 < n ? x.data()[i + 1] - x.data()[i] : -x.data()[i];
      f.data()[i] += left + right + 3 * (left * left * left + right * right * right);
    }
  }
  void add(double, const auto& y, auto& out) const {
    if constexpr (requires { out.force; }) add_to(y.r, out.force);
    else add_to(y.y, out.rate);
  }
};
struct DampedChain : Chain {
  static constexpr bool uses_velocity = true;
  void add(double t, const auto& y, auto& out) const {
    Chain::add(t, y, out);
    if constexpr (requires { out.force; }) out.force -= 0.1 * y.v;
  }
};
struct AnalyticChain : Chain {
  void add_jacobian(double, const auto& y, auto& sink) const {
    const auto& x = y.y;
    const Eigen::Index n = x.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      const double left = i > 0 ? x[i - 1] - x[i] : -x[i], right = i + 1 < n ? x[i + 1] - x[i] : -x[i];
      const double kl = 1 + 9 * left * left, kr = 1 + 9 * right * right;
      if (i > 0) sink.rate(i, i - 1, kl);
      sink.rate(i, i, -kl - kr);
      if (i + 1 < n) sink.rate(i, i + 1, kr);
    }
  }
};
struct SparseChain : AnalyticChain {
  [[maybe_unused]] static constexpr Structure structure = Structure::sparse;  // a solver of one's own implies it
};
struct BandedChain : AnalyticChain {
  [[maybe_unused]] static constexpr Structure structure = Structure::banded;
};
static_assert(ForceTraits<SparseChain, FirstOrderView<Dynamic, UnitMass>, RateOf<Dynamic>>::has_jacobian);

/// What is being checked, for the message.
const char* under_test = "";

// The loops and checks are plain functions: a template compiles no more than its stepper.
using Step = std::function<StepReport(double t, double dt)>;
[[maybe_unused]] std::int64_t allocations_of(const Step& step, int warm) {
  std::int64_t total = 0;
  for (int n = 0; n < 10 + warm; ++n) {
    heap::count = 0;
    heap::counting = n >= warm;
    const StepReport done = step(0.1 * n, 0.02 + 0.001 * n);
    heap::counting = false;
    total += heap::count;
    CAPTURE(under_test);
    REQUIRE(done);
  }
  return total;
}
/// Allocations in ten steps of growing dt (so that Jacobian and factors are renewed), after `warm` steps.
template <class S>
std::int64_t allocations(S& state, auto& stepper, int warm = 0) {
  return allocations_of([&](double t, double dt) { return stepper.step(state, t, dt); }, warm);
}
[[maybe_unused]] void check_no_allocation(const Step& step) {
  Eigen::internal::set_is_malloc_allowed(false);
  const std::int64_t count = allocations_of(step, 0);
  Eigen::internal::set_is_malloc_allowed(true);
  CAPTURE(under_test);
  CHECK(count == 0);
}
/// The same with Eigen's own witness, which ends the program where Eigen allocates.
template <class S>
void check_none(S state, auto force, auto scheme, const auto&... more) {
  PhiStepper stepper{state, force, scheme, more...};
  check_no_allocation([&](double t, double dt) { return stepper.step(state, t, dt); });
}

[[maybe_unused]] Motion<Dynamic> motion(Eigen::Index n) {
  return {Dynamic::LinSpaced(n, -1, 1), Dynamic::LinSpaced(n, 0.5, -0.5)};
}

}  // namespace
