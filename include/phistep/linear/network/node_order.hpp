/// @file
/// Graphs: the pairs of each node, and an order of the nodes in which neighbours stand close together, for the caches' sake.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <utility>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

using NodePair = std::pair<std::int32_t, std::int32_t>;

/// Pairs of nodes, node by node. A workspace: its buffers serve again.
/// @tparam Mark  what is known of a pair
template <class Mark>
class PairGraph {
 public:
  struct Edge {
    std::int32_t other;
    Mark mark;
  };

  void forget() { nodes_ = -1; }
  [[nodiscard]] bool is_of(Eigen::Index nodes) const { return nodes_ == nodes; }
  [[nodiscard]] std::span<const Edge> of(std::integral auto i) const {
    const auto s = static_cast<std::size_t>(i);
    return {edges_.data() + first_[s], static_cast<std::size_t>(first_[s + 1] - first_[s])};
  }
  /// @param pairs  calls f(i, j, mark) for each, in any order, the same twice over
  void build(Eigen::Index nodes, auto&& pairs) {
    nodes_ = -1;
    first_.assign(static_cast<std::size_t>(nodes) + 1, 0);
    pairs([&](Eigen::Index i, Eigen::Index j, Mark) {
      ++first_[static_cast<std::size_t>(i)], ++first_[static_cast<std::size_t>(j)];
    });
    std::int32_t sum = 0;
    for (std::int32_t& count : first_) sum += count, count = sum;  // where the next node's begin
    edges_.resize(static_cast<std::size_t>(sum));
    // Backwards, so that first_ ends where each node's own begin.
    pairs([&](Eigen::Index i, Eigen::Index j, Mark mark) {
      edges_[static_cast<std::size_t>(--first_[static_cast<std::size_t>(i)])] = {static_cast<std::int32_t>(j), mark};
      edges_[static_cast<std::size_t>(--first_[static_cast<std::size_t>(j)])] = {static_cast<std::int32_t>(i), mark};
    });
    nodes_ = nodes;
  }
  /// Sorts the edges of each node.
  void sort(const auto& is_before) {
    for (std::size_t i = 0; i + 1 < first_.size(); ++i)
      std::sort(edges_.begin() + first_[i], edges_.begin() + first_[i + 1], is_before);
  }

 private:
  std::vector<std::int32_t> first_;
  std::vector<Edge> edges_;
  Eigen::Index nodes_ = -1;
};

/// Cuthill and McKee's order (Proc. 24th ACM Nat. Conf., 1969): breadth first, fewest neighbours first. Returns the new
/// number of each node. (A template, so that programs without a graph don't compile the sorting.)
template <class Pairs = std::vector<NodePair>>
[[nodiscard]] std::vector<std::int32_t> cuthill_mckee(std::size_t nodes, const Pairs& edges) {
  PairGraph<bool> graph;
  graph.build(static_cast<Eigen::Index>(nodes), [&](auto&& put) {
    for (auto edge = edges.rbegin(); edge != edges.rend(); ++edge) put(edge->first, edge->second, {});
  });
  const auto degree = [&](std::int32_t i) { return graph.of(i).size(); };
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
      for (const auto& edge : graph.of(i))
        if (number[static_cast<std::size_t>(edge.other)] < 0) visit(edge.other);
      std::stable_sort(order.begin() + static_cast<std::ptrdiff_t>(fresh), order.end(),
                       [&](auto a, auto b) { return degree(a) < degree(b); });
      for (std::size_t k = fresh; k < order.size(); ++k)
        number[static_cast<std::size_t>(order[k])] = static_cast<std::int32_t>(k);
    }
  }
  return number;
}

/// The given numbering, unless neighbours are in sum more than twice as far apart as in Cuthill and McKee's: then that.
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
