/// @file
/// Threads: splits a loop into contiguous ranges, one per thread, and carries their exceptions out of the parallel region.
/// Results must not depend on the number of threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/version.hpp"

#ifdef _OPENMP
#include <omp.h>
#endif

namespace phistep { inline namespace PHISTEP_ABI {

/// How many threads share work from here.
[[nodiscard]] inline std::size_t thread_count() {
#ifdef _OPENMP
  return static_cast<std::size_t>(omp_get_max_threads());
#else
  return 1;
#endif
}

/// What one of several takes of 0 … n − 1: begin … end − 1.
struct Share {
  std::size_t number, begin, end;

  /// @param unit    the size of each share but the last is a multiple of it
  /// @param which   the number of this share, 0 … among − 1
  Share(std::size_t n, std::size_t unit, std::size_t which, std::size_t among) : number{which} {
    const std::size_t units = (n + unit - 1) / unit;
    begin = std::min(n, units * which / among * unit);
    end = std::min(n, units * (which + 1) / among * unit);
  }
};
/// The share of the calling thread of a parallel region.
[[nodiscard]] inline Share own_share(std::size_t n) {
#ifdef _OPENMP
  return {n, 1, static_cast<std::size_t>(omp_get_thread_num()), static_cast<std::size_t>(omp_get_num_threads())};
#else
  return {n, 1, 0, 1};
#endif
}

/// Numbers from which threads share a pass over them: waking them takes some 5 µs, the pass 0.2 to 1 ns a number.
inline constexpr std::size_t shared_from = std::size_t{1} << 16;

/// f(share) for thread_count() shares, at the same time: at each call the same ones; where n is less than `least`, for one
/// that is all. f throws nothing.
void for_each_share(std::size_t n, std::size_t unit, std::size_t least, const auto& f) {
  const std::size_t shares = n >= least ? thread_count() : 1;
  if (shares == 1) return f(Share{n, unit, 0, 1});
  PHISTEP_DETAIL_OMP("omp parallel for schedule(static, 1)")
  for (std::size_t t = 0; t < shares; ++t) f(Share{n, unit, t, shares});
}
/// f(begin, end) for ranges of 0 … n − 1 that begin at multiples of `unit`, likewise.
void for_each_range(std::ptrdiff_t n, std::ptrdiff_t unit, const auto& f, std::size_t least = shared_from) {
  if (n < static_cast<std::ptrdiff_t>(least)) return f(std::ptrdiff_t{0}, n);
  for_each_share(static_cast<std::size_t>(n), static_cast<std::size_t>(unit), 0, [&f](const Share& share) {
    if (share.begin < share.end) f(static_cast<std::ptrdiff_t>(share.begin), static_cast<std::ptrdiff_t>(share.end));
  });
}

/// Carries an exception out of an OpenMP region, where it would end the program: threads run their shares of the work
/// through it; behind the region, rethrow() throws the first exception of all, if there was one. Compiled without OpenMP, an
/// exception just passes.
class Relay {
 public:
  void run(auto&& share) {
#ifdef _OPENMP
    try {
      share();
    } catch (...) {
#pragma omp critical(phistep_relay)
      if (!first_) first_ = std::current_exception();
    }
#else
    share();
#endif
  }
  void rethrow() const {
    if (first_) std::rethrow_exception(first_);
  }

 private:
  std::exception_ptr first_;
};

}}  // namespace phistep::PHISTEP_ABI
