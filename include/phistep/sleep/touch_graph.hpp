/// @file
/// Who may act on whom, as far as somebody who moves has to look for somebody who sleeps.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The pairs that a force lists, body by body. A workspace, its buffers serve again.
class TouchGraph {
 public:
  struct Edge {
    std::int32_t other;
    bool by_touch;  ///< nothing acts before the two touch
  };

  void forget() { bodies_ = -1; }
  [[nodiscard]] bool is_of(Index bodies) const { return bodies_ == bodies; }
  [[nodiscard]] std::span<const Edge> of(Index i) const {
    const auto s = static_cast<std::size_t>(i);
    return {edges_.data() + first_[s], static_cast<std::size_t>(first_[s + 1] - first_[s])};
  }
  /// @param pairs  calls f(i, j, by_touch) for each, in any order, the same twice over
  void build(Index bodies, auto&& pairs) {
    bodies_ = -1;
    first_.assign(static_cast<std::size_t>(bodies) + 1, 0);
    pairs(
        [&](Index i, Index j, bool) { ++first_[static_cast<std::size_t>(i)], ++first_[static_cast<std::size_t>(j)]; });
    std::int32_t sum = 0;
    for (std::int32_t& count : first_) sum += count, count = sum;  // where the next body's begin
    edges_.resize(static_cast<std::size_t>(sum));
    // Backwards, so that first_ ends where each body's own begin.
    pairs([&](Index i, Index j, bool by_touch) {
      const auto put = [&](Index of, Index other) {
        edges_[static_cast<std::size_t>(--first_[static_cast<std::size_t>(of)])] = {static_cast<std::int32_t>(other),
                                                                                    by_touch};
      };
      put(i, j), put(j, i);
    });
    bodies_ = bodies;
  }

  /// Whether i acts on the other of its edge, or will within a step: spheres that touch, or may before |v| Δt has passed
  /// twice; a hundredth of their radii counts as touching.
  template <class S>
  [[nodiscard]] static bool acts(const S& y, Index i, const Edge& edge, ScalarOf<S> dt) {
    if (!edge.by_touch || y.radius().size() != y.size()) return true;
    using Scalar = ScalarOf<S>;
    const Index j = edge.other;
    const Scalar radii = y.radius()[i] + y.radius()[j];
    const Scalar reach = radii * Scalar(1.01) + 2 * std::abs(dt) * (y.v.col(i).norm() + y.v.col(j).norm());
    typename S::Vector d = y.r.col(i) - y.r.col(j);
    const auto& box = y.box();
    for (Index a = 0; a < d.size(); ++a)
      if (box.is_periodic[static_cast<std::size_t>(a)]) {
        const Scalar period = box.upper[a] - box.lower[a];
        d[a] -= period * std::round(d[a] / period);
      }
    return !(d.squaredNorm() >= reach * reach);
  }

 private:
  std::vector<std::int32_t> first_;
  std::vector<Edge> edges_;
  Index bodies_ = -1;
};

}}  // namespace phistep::PHISTEP_ABI
