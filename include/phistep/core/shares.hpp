/// @file
/// How threads share the work of a pass.
#pragma once

#include <algorithm>
#include <cstddef>

#include "phistep/core/version.hpp"

#ifdef _OPENMP
#include <omp.h>
#endif

namespace phistep::inline PHISTEP_ABI {

/// Thread t takes what stands from begin(t) to end(t) − 1.
class Shares {
 public:
  [[nodiscard]] static std::size_t threads() {
#ifdef _OPENMP
    return static_cast<std::size_t>(omp_get_max_threads());
#else
    return 1;
#endif
  }

  /// @param unit  each share but the last is a multiple of it
  explicit Shares(std::size_t n, std::size_t unit = 1)
      : n_{n}, share_{((n + threads() - 1) / threads() + unit - 1) / unit * unit} {}
  [[nodiscard]] std::size_t begin(std::size_t t) const { return std::min(n_, t * share_); }
  [[nodiscard]] std::size_t end(std::size_t t) const { return std::min(n_, begin(t) + share_); }

 private:
  std::size_t n_, share_;
};

/// The part of 0 … n − 1 that the calling thread of a parallel region takes: begin … end − 1.
struct TeamShare {
  std::size_t begin, end;
  /// @param unit  each share but the last is a multiple of it
  explicit TeamShare(std::size_t n, std::size_t unit = 1) : begin{0}, end{n} {
#ifdef _OPENMP
    const auto team = static_cast<std::size_t>(omp_get_num_threads()),
               me = static_cast<std::size_t>(omp_get_thread_num()), units = (n + unit - 1) / unit;
    begin = std::min(n, units * me / team * unit), end = std::min(n, units * (me + 1) / team * unit);
#else
    static_cast<void>(unit);
#endif
  }
};

/// Numbers from which threads share a pass over them: waking them takes some 5 µs, the pass 0.2 to 1 ns a number.
inline constexpr std::ptrdiff_t shared_from = std::ptrdiff_t{1} << 16;

/// f(begin, end) for parts of 0 … n − 1, which threads take at the same time; in the caller's own thread f(0, n) where n is
/// less than `least`. f must find the same whatever the parts are, and throw nothing.
/// @param unit  parts begin at multiples of it
void for_each_share(std::ptrdiff_t n, std::ptrdiff_t unit, const auto& f, std::ptrdiff_t least = shared_from) {
#ifdef _OPENMP
  if (n >= least) {
#pragma omp parallel
    {
      const TeamShare part{static_cast<std::size_t>(n), static_cast<std::size_t>(unit)};
      if (part.begin < part.end) f(static_cast<std::ptrdiff_t>(part.begin), static_cast<std::ptrdiff_t>(part.end));
    }
    return;
  }
#endif
  static_cast<void>(unit), static_cast<void>(least);
  f(std::ptrdiff_t{0}, n);
}

}  // namespace phistep::inline PHISTEP_ABI
