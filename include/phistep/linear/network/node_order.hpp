/// @file
/// An order of a graph's nodes in which neighbours stand close together, for the caches' sake.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

using NodePair = std::pair<std::int32_t, std::int32_t>;

/// Cuthill and McKee's order (Proc. 24th ACM Nat. Conf., 1969): breadth first, fewest neighbours first. Returns the new
/// number of each node. (A template, so that programs without a graph don't compile the sorting.)
template <class Pairs = std::vector<NodePair>>
[[nodiscard]] std::vector<std::int32_t> cuthill_mckee(std::size_t nodes, const Pairs& edges) {
  std::vector<std::int32_t> start(nodes + 1, 0), neighbours(2 * edges.size());
  for (const auto& [i, j] : edges) ++start[static_cast<std::size_t>(i) + 1], ++start[static_cast<std::size_t>(j) + 1];
  for (std::size_t i = 0; i < nodes; ++i) start[i + 1] += start[i];
  std::vector<std::int32_t> at(start.begin(), start.end() - 1);
  const auto put = [&](std::int32_t i, std::int32_t j) {
    neighbours[static_cast<std::size_t>(at[static_cast<std::size_t>(i)]++)] = j;
  };
  for (const auto& [i, j] : edges) put(i, j), put(j, i);
  const auto degree = [&](std::int32_t i) {
    return start[static_cast<std::size_t>(i) + 1] - start[static_cast<std::size_t>(i)];
  };
  std::vector<std::int32_t> number(nodes, -1), seeds(nodes), order;
  order.reserve(nodes);
  for (std::size_t i = 0; i < nodes; ++i) seeds[i] = static_cast<std::int32_t>(i);
  std::stable_sort(seeds.begin(), seeds.end(), [&](auto a, auto b) { return degree(a) < degree(b); });
  const auto visit = [&](std::int32_t i) {
    number[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(order.size());
    order.push_back(i);
  };
  for (const std::int32_t seed : seeds) {
    if (number[static_cast<std::size_t>(seed)] >= 0) continue;
    std::size_t next = order.size();
    for (visit(seed); next < order.size(); ++next) {
      const std::int32_t i = order[next];
      const std::size_t fresh = order.size();
      for (auto k = start[static_cast<std::size_t>(i)]; k < start[static_cast<std::size_t>(i) + 1]; ++k)
        if (const std::int32_t j = neighbours[static_cast<std::size_t>(k)]; number[static_cast<std::size_t>(j)] < 0)
          visit(j);
      std::stable_sort(order.begin() + static_cast<std::ptrdiff_t>(fresh), order.end(),
                       [&](auto a, auto b) { return degree(a) < degree(b); });
      for (std::size_t k = fresh; k < order.size(); ++k)
        number[static_cast<std::size_t>(order[k])] = static_cast<std::int32_t>(k);
    }
  }
  return number;
}

/// The given numbers where they keep neighbours about as close as Cuthill and McKee's would, else theirs.
template <class Pairs = std::vector<NodePair>>
[[nodiscard]] std::vector<std::int32_t> close_order(std::size_t nodes, const Pairs& edges) {
  std::vector<std::int32_t> given(nodes);
  for (std::size_t i = 0; i < nodes; ++i) given[i] = static_cast<std::int32_t>(i);
  const auto span = [&](const std::vector<std::int32_t>& number) {
    double sum = 0;
    for (const auto& [i, j] : edges)
      sum += std::abs(number[static_cast<std::size_t>(i)] - number[static_cast<std::size_t>(j)]);
    return sum;
  };
  std::vector<std::int32_t> closer = cuthill_mckee(nodes, edges);
  return span(given) > 2 * span(closer) ? closer : given;
}

}}  // namespace phistep::PHISTEP_ABI
