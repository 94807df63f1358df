/// @file
/// How large a state is, in weights: what controllers and solves judge.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <type_traits>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// √(1/n Σ (x_i w_i)²)
template <State Plain>
[[nodiscard]] double weighted_rms(const Plain& x, const Plain& weight) {
  const Index n = count_of(Blocks<Plain>::all(x));
  if constexpr (FieldState<Plain>) {
    double sum = 0;
    for_each_block(
        [&sum](auto, const auto& of, const auto& w) {
          sum += std::remove_cvref_t<decltype(of)>::Ops::square(of.handle(), w.handle());
        },
        Blocks<Plain>::all(x), Blocks<Plain>::all(weight));
    total_of_ranks(x, std::span<double>{&sum, 1});
    return n == 0 ? 0 : std::sqrt(sum / static_cast<double>(n));
  } else {
    using Wide = std::common_type_t<ScalarOf<Plain>, double>;  // squares of floats soon leave their range
    const auto mean_square = [&](auto scaled) {
      Wide sum{0};
      for_each_number(
          [&sum, scaled](std::size_t, auto of, auto w) {
            const Wide part = scaled(static_cast<Wide>(of * w));
            sum += part * part;
          },
          Blocks<Plain>::all(x), Blocks<Plain>::all(weight));
      return static_cast<double>(sum / static_cast<Wide>(n));
    };
    if (n == 0) return 0;
    const double square = mean_square([](Wide part) { return part; });
    if (0x1p-1000 <= square && square <= 0x1p1000) return std::sqrt(square);
    // Squares that leave the range: rates per unit of a time that is far too long or too short for them.
    if (square > 1) return 0x1p520 * std::sqrt(mean_square([](Wide part) { return part * Wide{0x1p-520}; }));
    return 0x1p-520 * std::sqrt(mean_square([](Wide part) { return part * Wide{0x1p520}; }));
  }
}

}}  // namespace phistep::PHISTEP_ABI
