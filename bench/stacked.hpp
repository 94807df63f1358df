/// @file
/// A state as one vector.
#pragma once

#include <phistep/base/state/blocks.hpp>

namespace bench {

/// The state as one vector, r before v.
template <class S>
[[nodiscard]] Eigen::VectorXd stacked(const S& y) {
  if constexpr (phistep::EigenDense<S>) {
    return y;
  } else {
    Eigen::VectorXd x(2 * y.r.size());
    x << y.r.reshaped(), y.v.reshaped();
    return x;
  }
}

}  // namespace bench
