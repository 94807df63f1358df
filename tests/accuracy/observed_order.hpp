#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "support/catch.hpp"

namespace convergence {

/// error(n), error(2n), error(4n), error(8n): three halvings of the step.
template <class Error>
[[nodiscard]] std::array<double, 4> errors(int n, Error&& error) {
  return {error(n), error(2 * n), error(4 * n), error(8 * n)};
}

/// Each halving must show the order, from both sides: a scheme that converges faster than it should is wrong too.
inline void check_order(const std::array<double, 4>& e, double order, double tolerance = 0.05) {
  CAPTURE(e[0], e[1], e[2], e[3]);
  for (std::size_t k = 0; k < 3; ++k) {
    const double observed = std::log2(e[k] / e[k + 1]);
    CAPTURE(k, observed);
    CHECK(std::abs(observed - order) <= tolerance);
  }
}

}  // namespace convergence
