/// @file
/// Where particles live, as the neighbour list sees it: which axes repeat, and how often a coordinate has to be shifted
/// to lie in the first period.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A box without its number type. An axis that does not repeat is open: `lower` and `length` do not bind there.
struct Domain {
  std::array<double, 3> lower{}, length{};  ///< [length]
  std::array<bool, 3> periodic{};

  bool operator==(const Domain&) const = default;

  /// k with x + k·length in [lower, lower + length], up to rounding. 0 on an open axis and for what is not a number.
  [[nodiscard]] std::int32_t image(std::size_t axis, double x) const {
    if (!periodic[axis]) return 0;
    const double k = -std::floor((x - lower[axis]) / length[axis]);
    return std::abs(k) < 1e9 ? static_cast<std::int32_t>(k) : 0;
  }
};

/// The domain of a `Box<Scalar, dim>`.
template <class Box>
[[nodiscard]] Domain domain_of(const Box& box) {
  Domain domain;
  for (std::size_t a = 0; a < box.is_periodic.size(); ++a) {
    domain.periodic[a] = box.is_periodic[a];
    if (!box.is_periodic[a]) continue;
    const auto axis = static_cast<std::ptrdiff_t>(a);
    domain.lower[a] = static_cast<double>(box.lower[axis]);
    domain.length[a] = static_cast<double>(box.upper[axis]) - static_cast<double>(box.lower[axis]);
  }
  return domain;
}

}}  // namespace phistep::PHISTEP_ABI
