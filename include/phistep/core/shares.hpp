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

}  // namespace phistep::inline PHISTEP_ABI
