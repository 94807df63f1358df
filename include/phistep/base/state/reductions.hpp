/// @file
/// Reductions over a state: how large it is, in weights, what controllers and solves judge; where it is not finite, for messages.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/ranks.hpp"

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

/// Which component of which block is not finite; block −1 where all are, index −1 where the block is a field.
template <class Tie>
[[nodiscard]] ComponentLocation first_non_finite(const Tie& blocks) {
  ComponentLocation found;
  for_each_block(
      [&found](auto k, const auto& x) {
        if (found) return;
        if constexpr (FieldBlock<decltype(x)>) {
          if (!is_finite_block(x)) found.block = static_cast<std::int64_t>(k());
        } else {
          for (Index j = 0; j < x.cols(); ++j)
            for (Index i = 0; i < x.rows(); ++i)
              if (!std::isfinite(x(i, j))) {
                found = {static_cast<std::int64_t>(k()), x.IsRowMajor ? i * x.cols() + j : j * x.rows() + i, -1, -1};
                if (x.cols() > 1) found.row = i, found.column = j;
                return;
              }
        }
      },
      blocks);
  return found;
}

}}  // namespace phistep::PHISTEP_ABI
