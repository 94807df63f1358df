/// @file
/// Short loops written out, for kernels: at -O2 g++ 12 leaves `for (int a = 0; a < 3; ++a)` a loop, and what it indexes in
/// memory.
#pragma once

#include <type_traits>

#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI { namespace detail {

/// f(0), f(1) … f(n − 1) with constants for arguments, so that arrays of packs stay in registers.
template <int n, int k = 0, class F>
[[gnu::always_inline]] inline void unrolled(F&& f) {
  if constexpr (k < n) {
    f(std::integral_constant<int, k>{});
    unrolled<n, k + 1>(f);
  }
}

}}}  // namespace phistep::PHISTEP_ABI::detail
