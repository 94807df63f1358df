/// @file
/// Where a state or a rate is not finite, for messages.
#pragma once

#include <cmath>
#include <cstdint>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Which component of which block is not finite; block −1 where all are, index −1 where the block is a field.
struct Offender {
  std::int64_t block = -1, index = -1, row = -1, column = -1;
  [[nodiscard]] explicit operator bool() const { return block >= 0; }
};

template <class Tie>
[[nodiscard]] Offender first_non_finite(const Tie& blocks) {
  Offender found;
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
