/// @file
/// How large a state is, in weights: what controllers and solves judge.
#pragma once

#include <cmath>
#include <cstddef>
#include <type_traits>

#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// √(1/n Σ (x_i w_i)²)
template <State Plain>
[[nodiscard]] double weighted_rms(const Plain& x, const Plain& weight) {
  using Wide = std::common_type_t<ScalarOf<Plain>, double>;  // squares of floats soon leave their range
  Wide sum{0};
  for_each_number(
      [&sum](std::size_t, auto of, auto w) {
        const Wide part = static_cast<Wide>(of * w);
        sum += part * part;
      },
      Blocks<Plain>::all(x), Blocks<Plain>::all(weight));
  const Index n = count_of(Blocks<Plain>::all(x));
  return n == 0 ? 0 : std::sqrt(static_cast<double>(sum / static_cast<Wide>(n)));
}

}  // namespace phistep::inline PHISTEP_ABI
