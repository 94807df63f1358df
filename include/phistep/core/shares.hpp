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
  std::size_t number = 0;  ///< of the thread
  /// @param unit  each share but the last is a multiple of it
  explicit TeamShare(std::size_t n, std::size_t unit = 1) : begin{0}, end{n} {
#ifdef _OPENMP
    number = static_cast<std::size_t>(omp_get_thread_num());
    const auto team = static_cast<std::size_t>(omp_get_num_threads()), units = (n + unit - 1) / unit;
    begin = std::min(n, units * number / team * unit), end = std::min(n, units * (number + 1) / team * unit);
#else
    static_cast<void>(unit);
#endif
  }
};

/// Numbers from which threads share a pass over them: waking them takes some 5 µs, the pass 0.2 to 1 ns a number.
inline constexpr std::ptrdiff_t shared_from = std::ptrdiff_t{1} << 16;

/// f(share) by each thread of a team; where n is less than `least`, by the caller alone. f throws nothing.
void for_each_team_share(std::size_t n, std::size_t unit, const auto& f, [[maybe_unused]] std::size_t least) {
#ifdef _OPENMP
#pragma omp parallel if (n >= least)
#endif
  f(TeamShare{n, unit});
}
/// f(begin, end) for parts of 0 … n − 1, which threads take at the same time; where n is less than `least`, f(0, n). f must
/// find the same whatever the parts are, and throw nothing.
/// @param unit  parts begin at multiples of it
void for_each_share(std::ptrdiff_t n, std::ptrdiff_t unit, const auto& f, std::ptrdiff_t least = shared_from) {
  if (n < least) return f(std::ptrdiff_t{0}, n);
  const auto share_of = [&f](const TeamShare& share) {
    if (share.begin < share.end) f(static_cast<std::ptrdiff_t>(share.begin), static_cast<std::ptrdiff_t>(share.end));
  };
  for_each_team_share(static_cast<std::size_t>(n), static_cast<std::size_t>(unit), share_of, 0);
}

}  // namespace phistep::inline PHISTEP_ABI
