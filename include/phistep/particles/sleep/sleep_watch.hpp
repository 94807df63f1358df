/// @file
/// Who wakes whom: sleepers beside somebody who moves.
///
/// After each step two lists are gone through, and no others: the pairs of somebody awake with a sleeper, who is watched as
/// soon as the two touch; and those who are watched, beside whom sleepers are watched when they become fast or have come too
/// far. From time to time those who are watched and touch nobody awake are put to sleep.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/force/local.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/particles/sleep/sleepers.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// Which particles a term of a force may let act on each other: needed where some are left out.

/// Who may act on whom. A term of pairs offers `for_each_pair(memory, f)`, with f(i, j) called for every pair that acts or
/// may soon act, indices being the user's, and `pair_changes()`, a number that changes where others may act from now on
/// (without it, pairs are asked for at each step); `acts_by_touch` says that spheres apart don't act. One that acts on each
/// particle by itself says `acts_on_each`.
template <class F, int dim>
inline constexpr bool tells_its_pairs = requires(F& f, const MemoryOf<F>& memory, void (*pair)(Index, Index)) {
  f.for_each_pair(memory, pair);
}
|| is_particlewise<F, dim> || requires { requires F::acts_on_each; };
template <class... T, int dim>
inline constexpr bool tells_its_pairs<Sum<T...>, dim> = (tells_its_pairs<Unwrapped<T>, dim> && ...);

/// pair(i, j, by_touch) for all.
template <class F, class Memory, class Pair>
void for_each_pair_of(F& force, const Memory& memory, Pair&& pair) {
  constexpr bool by_touch = requires { requires F::acts_by_touch; };
  const auto put = [&pair](Index i, Index j) { pair(i, j, by_touch); };
  if constexpr (is_sum<F>)
    for_each_term(force, memory, [&pair](auto, auto& term, const auto& its) { for_each_pair_of(term, its, pair); });
  else if constexpr (requires { force.for_each_pair(memory, put); }) force.for_each_pair(memory, put);
}

/// A number that changes where for_each_pair_of changes; −1 where unknown.
template <class F>
[[nodiscard]] std::int64_t pair_changes_of(F& force) {
  if constexpr (is_sum<F>) {
    return std::apply(
        [](auto&... term) {
          const std::int64_t changes[] = {0, pair_changes_of(unwrap(term))...};
          std::int64_t sum = 0;
          for (const std::int64_t some : changes) sum = some < 0 || sum < 0 ? -1 : sum + some;
          return sum;
        },
        force.terms);
  } else if constexpr (requires { force.pair_changes(); }) {
    return static_cast<std::int64_t>(force.pair_changes());
  } else {
    constexpr bool has_pairs = requires(const MemoryOf<F>& memory, void (*pair)(Index, Index)) {
      force.for_each_pair(memory, pair);
    };
    return has_pairs ? -1 : 0;
  }
}

/// The pairs that a force lists, body by body: which particles may act on which. A workspace: its buffers serve again.
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

template <class S>
class SleepWatch {
 public:
  using Scalar = ScalarOf<S>;

  /// Indices mean other particles from now on.
  void forget() { graph_.forget(); }
  /// Pairs of the force are those of the graph, from now on. @param memory  of the force
  void follow_pairs(const Sleepers<S>& sleepers, auto& force, const auto& memory) {
    const std::int64_t changes = pair_changes_of(force);
    if (graph_.is_of(sleepers.size()) && changes >= 0 && changes == pair_changes_) return;
    graph_.build(sleepers.size(), [&](auto&& f) { for_each_pair_of(force, memory, f); });
    pair_changes_ = changes;
    find_frontier(sleepers);
  }
  /// Makes the lists anew.
  /// @param computed  particles, ascending
  void follow_kinds(const Sleepers<S>& sleepers, const std::vector<std::int32_t>& computed) {
    watched_.clear(), disturbing_.clear();
    for (const std::int32_t i : computed) (sleepers[i].disturbs() ? disturbing_ : watched_).push_back(i);
    disturbing_.insert(disturbing_.end(), supports_.begin(), supports_.end());
    find_frontier(sleepers);
  }
  /// Those that are held by the user and move.
  [[nodiscard]] const std::vector<std::int32_t>& moving_supports() const { return supports_; }
  void find_supports(const Sleepers<S>& sleepers) {
    supports_.clear();
    for (Index i = 0; i < sleepers.size(); ++i)
      if (sleepers[i].kind == Kind::held && sleepers[i].moves) supports_.push_back(static_cast<std::int32_t>(i));
  }

  /// After a step: whom somebody awake or fast has reached is watched.
  void wake_reached(Sleepers<S>& sleepers, const S& state, Scalar dt) {
    for (const auto& [i, edge] : frontier_) wake_by(sleepers, state, i, edge, dt);
    for (const std::int32_t i : watched_) {
      Sleeper& one = sleepers[i];
      const bool fast = sleepers.is_fast(state, i);
      if (fast) one.kind = Kind::awake, one.quiet = 0, sleepers.changed = true;
      else if (!sleepers.has_moved(state, i, dt)) continue;
      sleepers.rest.col(i) = state.r.col(i);
      for (const TouchGraph::Edge& edge : graph_.of(i)) wake_by(sleepers, state, i, edge, dt);
    }
  }
  /// Whoever may touch i is watched.
  void wake_beside(Sleepers<S>& sleepers, Index i) const {
    if (!graph_.is_of(sleepers.size())) return sleepers.wake_all();
    for (const TouchGraph::Edge& edge : graph_.of(i))
      if (sleepers[edge.other].is_asleep()) sleepers.wake(edge.other, Kind::watched);
  }
  /// Puts to sleep who is watched and touches nobody awake; where that would not pay, nobody sleeps.
  void lull(Sleepers<S>& sleepers, S& state, Scalar dt, auto& force, const auto& memory) {
    tired_.clear();
    for (const std::int32_t i : watched_)
      if (sleepers[i].kind == Kind::watched && sleepers.may_sleep(state, i)) tired_.push_back(i);
    if (!tired_.empty() && is_worth(sleepers)) {
      follow_pairs(sleepers, force, memory);
      std::erase_if(tired_, [&](Index i) {
        const auto around = graph_.of(i);
        return std::any_of(around.begin(), around.end(), [&](const TouchGraph::Edge& edge) {
          return sleepers[edge.other].disturbs() && TouchGraph::acts(state, i, edge, dt);
        });
      });
    }
    if (is_worth(sleepers)) {
      for (const std::int32_t i : tired_) sleepers.fall_asleep(state, i);
    } else if (sleepers.report.asleep > 0) {
      sleepers.unrest = 3;  // too few could sleep: is_worth() refuses until this has decayed
      for (Index i = 0; i < sleepers.size(); ++i)
        if (sleepers[i].is_asleep()) sleepers.wake(i, Kind::watched);
    }
  }

 private:
  using Kind = Sleeper::Kind;
  struct Meeting {
    std::int32_t mover;
    TouchGraph::Edge edge;
  };

  [[nodiscard]] bool is_worth(const Sleepers<S>& sleepers) const {
    // Lists for another active set cost 0.3 of a full step, and more where many wake.
    const double share = 0.1 + 0.3 * sleepers.unrest;
    return static_cast<double>(sleepers.report.asleep + static_cast<std::int64_t>(tired_.size())) >=
           share * static_cast<double>(sleepers.free);
  }
  static void wake_by(Sleepers<S>& sleepers, const S& state, Index i, const TouchGraph::Edge& edge, Scalar dt) {
    if (sleepers[edge.other].is_asleep() && TouchGraph::acts(state, i, edge, dt))
      sleepers.wake(edge.other, Kind::watched);
  }
  void find_frontier(const Sleepers<S>& sleepers) {
    frontier_.clear();
    if (sleepers.report.asleep == 0 || !graph_.is_of(sleepers.size())) return;
    for (const std::int32_t i : disturbing_)
      for (const TouchGraph::Edge& edge : graph_.of(i))
        if (sleepers[edge.other].is_asleep()) frontier_.push_back({i, edge});
  }

  TouchGraph graph_;
  std::int64_t pair_changes_ = -1;
  std::vector<Meeting> frontier_;  // somebody awake, or a support that moves, and a sleeper
  std::vector<std::int32_t> watched_, disturbing_, supports_, tired_;
};

}}  // namespace phistep::PHISTEP_ABI
