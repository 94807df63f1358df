/// @file
/// How wide a skin: from counts, never from a clock, so that a run decides alike wherever it runs.
///
/// A list to r_c + s that served m steps, with L entries and T distances computed for each particle, has cost
///
///     C(s) = p L + (b + q T)/m                                                                                    (1)
///
/// a step and particle. With another skin L and T change as (r_c + s)^dim, and m as s: the fastest fly freely for that long.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a list took, and how long it served.
struct ListUse {
  double listed = 0, tested = 0;  ///< a particle
  std::int32_t steps = 1;
};

/// The skin of the next list [length]: that of the last one, or one of the two that are √2 times as long and as short, whichever
/// (1) says is cheapest. Within 0.06 and 2 cutoffs, and not beyond `longest`.
template <int dim>
[[nodiscard]] double next_skin(double cutoff, double skin, const ListUse& use, double longest) {
  constexpr double p = 1, q = 1, b = 150;  // of one entry's share of the force
  constexpr double rung = 1.4142135623730951, worth = 0.97;
  const auto cost = [&](double s) {
    const double more = std::pow((cutoff + s) / (cutoff + skin), dim);
    return p * use.listed * more + (b + q * use.tested * more) * skin / (s * std::max(use.steps, 1));
  };
  double best = skin, least = worth * cost(skin);
  for (const double s : {skin / rung, skin * rung})
    if (s >= 0.06 * cutoff && s <= std::min(2 * cutoff, longest) && cost(s) < least) best = s, least = cost(s);
  return best;
}

}}  // namespace phistep::PHISTEP_ABI
