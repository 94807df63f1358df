/// @file
/// What wakes a sleeper: a body that moves beside it, and what the user edits between two steps.
///
/// After each step two lists are gone through: pairs of a particle that is awake and a sleeper, which is watched as soon as they touch; and
/// watched particles, beside which sleepers are watched when they become fast or have moved too far. At checks, watched particles that
/// touch none that is awake are put to sleep. A particle whose numbers or properties were changed wakes; those beside a sleeper or a
/// support that was moved or erased are watched.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/archive/archive.hpp"
#include "phistep/base/numbers/fingerprint.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/particle_fingerprint.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/linear/network/node_order.hpp"
#include "phistep/particles/bodies/particle_sums.hpp"
#include "phistep/particles/sleep/sleepers.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Which particles may act on each other. A term of pairs offers `for_each_pair(memory, f)`, which calls f(i, j), the user's indices, for
/// every pair that acts or may soon act, and `pair_changes()`, a number that changes with these pairs (without it they are enumerated at
/// each step); `acts_by_touch` says that spheres apart don't act. A term on each particle by itself says `acts_on_each`.
template <class F>
inline constexpr bool lists_pairs = requires(F& f, const MemoryOf<F>& memory, void (*pair)(Index, Index)) {
  f.for_each_pair(memory, pair);
};
template <class F, int dim>
inline constexpr bool tells_its_pairs = lists_pairs<F> || acts_on_each<F, dim>;
template <class... T, int dim>
inline constexpr bool tells_its_pairs<Sum<T...>, dim> = (tells_its_pairs<Unwrapped<T>, dim> && ...);

/// pair(i, j, by_touch) for all pairs, or for the late ones: the few that may come and go while pair_changes() stays, which a term may
/// offer by `for_each_late_pair(memory, f)`.
template <bool late = false, class F, class Memory, class Pair>
void for_each_pair_of(F& force, const Memory& memory, Pair&& pair) {
  constexpr bool by_touch = requires { requires F::acts_by_touch; };
  const auto put = [&pair](Index i, Index j) { pair(i, j, by_touch); };
  if constexpr (is_sum<F>) {
    for_each_term(force, memory,
                  [&pair](auto, auto& term, const auto& its) { for_each_pair_of<late>(term, its, pair); });
  } else if constexpr (late) {
    if constexpr (requires { force.for_each_late_pair(memory, put); }) force.for_each_late_pair(memory, put);
  } else if constexpr (lists_pairs<F>) {
    force.for_each_pair(memory, put);
  }
}

template <class S>
class SleepWatch {
  using Edge = PairGraph<bool>::Edge;

 public:
  using Scalar = ScalarOf<S>;

  /// From now on indices mean other particles.
  void forget() { graph_.forget(); }
  /// Makes the graph of the force's pairs anew where these have changed. @param memory  of the force
  void follow_pairs(const Sleepers<S>& sleepers, auto& force, const auto& memory) {
    late_.clear();
    for_each_pair_of<true>(force, memory, [this](Index i, Index j, bool by_touch) {
      const auto put = [&](Index of, Index other) {
        late_.emplace_back(static_cast<std::int32_t>(of), Edge{static_cast<std::int32_t>(other), by_touch});
      };
      put(i, j), put(j, i);
    });
    std::int64_t changes = 0;
    bool is_known = graph_.is_of(sleepers.size());
    for_each_summand(force, [&](auto& term) {
      if constexpr (requires { term.pair_changes(); }) changes += static_cast<std::int64_t>(term.pair_changes());
      else is_known = is_known && !lists_pairs<std::remove_reference_t<decltype(term)>>;
    });
    if (is_known && changes == pair_changes_) return;
    graph_.build(sleepers.size(), [&](auto&& f) { for_each_pair_of(force, memory, f); });
    pair_changes_ = changes;
    find_frontier(sleepers);
  }
  /// Makes the lists anew.
  /// @param computed  particles, ascending
  void follow_kinds(const Sleepers<S>& sleepers, const std::vector<std::int32_t>& computed) {
    watched_.clear(), disturbing_.clear();
    for (const std::int32_t i : computed) (sleepers[i].disturbs() ? disturbing_ : watched_).push_back(i);
    disturbing_.insert(disturbing_.end(), sleepers.supports.begin(), sleepers.supports.end());
    find_frontier(sleepers);
  }

  /// After a step: a sleeper is watched that one awake or fast has reached.
  void wake_reached(Sleepers<S>& sleepers, const S& state, Scalar dt) {
    for (const auto& [i, edge] : frontier_) wake_by(sleepers, state, i, edge, dt);
    for (const auto& [i, edge] : late_)
      if (sleepers[i].disturbs() || (sleepers[i].kind == Kind::watched && stirs(sleepers, state, i, dt)))
        wake_by(sleepers, state, i, edge, dt);
    for (const std::int32_t i : watched_) {
      if (!stirs(sleepers, state, i, dt)) continue;
      Sleeper& one = sleepers[i];
      if (!sleepers.is_slow(state, i)) one.kind = Kind::awake, one.quiet = 0, sleepers.changed = true;
      one.rest = state.r.col(i);
      for (const Edge& edge : graph_.of(i)) wake_by(sleepers, state, i, edge, dt);
    }
  }
  /// Sleepers that may touch i are watched.
  void wake_beside(Sleepers<S>& sleepers, Index i) const {
    if (!graph_.is_of(sleepers.size())) return sleepers.wake_all();
    const auto wake = [&sleepers](Index other) {
      if (sleepers[other].is_asleep()) sleepers.wake(other, Kind::watched);
    };
    for (const Edge& edge : graph_.of(i)) wake(edge.other);
    for (const auto& [mover, edge] : late_)
      if (mover == i) wake(edge.other);
  }
  /// Puts watched particles to sleep that touch none that is awake; where that would not pay, all wake.
  void lull(Sleepers<S>& sleepers, S& state, Scalar dt, auto& force, const auto& memory) {
    tired_.clear();
    for (const std::int32_t i : watched_)
      if (sleepers[i].kind == Kind::watched && sleepers.may_sleep(state, i)) tired_.push_back(i);
    if (!tired_.empty() && is_worth(sleepers)) {
      follow_pairs(sleepers, force, memory);
      std::erase_if(tired_, [&](Index i) {
        const auto around = graph_.of(i);
        return std::any_of(around.begin(), around.end(), [&](const Edge& edge) {
          return sleepers[edge.other].disturbs() && acts(state, i, edge, dt);
        });
      });
      for (const auto& [i, edge] : late_)
        if (sleepers[i].disturbs() && acts(state, i, edge, dt)) std::erase(tired_, edge.other);
    }
    if (is_worth(sleepers)) {
      for (const std::int32_t i : tired_) sleepers.fall_asleep(state, i);
    } else if (sleepers.report.asleep > 0) {
      sleepers.unrest = 1.5;  // too few could sleep: is_worth() refuses until this has decayed
      for (Index i = 0; i < sleepers.size(); ++i)
        if (sleepers[i].is_asleep()) sleepers.wake(i, Kind::watched);
    }
  }

  /// After particles or properties were changed. True where anything differs.
  bool adopt_bodies(Sleepers<S>& sleepers, const S& state) {
    const auto& body = state.body();
    bool is_other = sleepers.id != state.id();
    if (is_other) {
      match(sleepers, state);
      forget();
    }
    Writer box;
    box(body.box, body.inertia_factor);
    const auto scene = fingerprint(box.bytes().data(), static_cast<std::ptrdiff_t>(box.bytes().size()));
    if (std::exchange(sleepers.scene, scene) != scene) is_other = true, sleepers.wake_all();
    for (Index i = 0; i < state.size(); ++i) {
      Sleeper& one = sleepers[i];
      const auto of = [i](const auto& column) { return column.size() == 0 ? 0 : static_cast<double>(column[i]); };
      const double all[] = {of(body.mass), of(body.radius), of(body.type), of(body.charge)};
      const std::uint64_t bits = fingerprint(all, 4);
      if (std::exchange(one.properties, bits) != bits) {
        is_other = true;
        if (one.is_asleep()) sleepers.wake(i, Kind::awake);
        one.slept = 0;  // it is owed by another force
      }
      if (body.is_still(i) == (one.kind == Kind::held)) continue;
      is_other = true;
      if (body.is_still(i)) hold(sleepers, state, i);
      else sleepers.start_awake(i);
    }
    if (is_other) sleepers.count();
    sleepers.changed = true;
    return is_other;
  }
  /// Whether a particle outside the active set `computed` was edited: one pass over the state.
  [[nodiscard]] static bool is_edited(const Sleepers<S>& sleepers, const S& state,
                                      const std::vector<std::int32_t>& computed) {
    const auto& supports = sleepers.supports;
    if (std::any_of(supports.begin(), supports.end(), [&](Index i) { return !Sleepers<S>::moves(state, i); }))
      return true;
    return ParticleFingerprint<S>::without(state, computed, supports) != sleepers.seen;
  }
  /// Wakes the particles that were edited, and watches their neighbours.
  void adopt_edits(Sleepers<S>& sleepers, const S& state) {
    for (Index i = 0; i < state.size(); ++i) {
      Sleeper& one = sleepers[i];
      if (one.is_computed() || (one.rests() && one.seen == ParticleFingerprint<S>::of(state, i))) continue;
      if (one.is_asleep()) {
        wake_beside(sleepers, i);
        sleepers.wake(i, Kind::awake);
        one.slept = 0;  // its speed is the user's
      } else {
        const bool stays = state.r.col(i) == one.rest;
        if (!stays && !one.moves) wake_beside(sleepers, i);
        hold(sleepers, state, i);
      }
    }
    sleepers.count();
    sleepers.changed = true;
  }
  /// Notes where particles are held: edits of them were not noticed while no particle slept.
  void look_at_supports(Sleepers<S>& sleepers, const S& state) {
    if (sleepers.free == sleepers.size()) return;
    for (Index i = 0; i < state.size(); ++i)
      if (sleepers[i].kind == Kind::held) hold(sleepers, state, i);
    sleepers.count();
    sleepers.changed = true;
  }

 private:
  using Kind = typename Sleepers<S>::Kind;
  using Sleeper = typename Sleepers<S>::Sleeper;
  using Meeting = std::pair<std::int32_t, Edge>;  // of one that moves

  [[nodiscard]] bool is_worth(const Sleepers<S>& sleepers) const {
    // Lists for another active set cost 0.3 of a full step, and more where many wake.
    const double share = 0.1 + 0.3 * sleepers.unrest;
    return static_cast<double>(sleepers.report.asleep + static_cast<std::int64_t>(tired_.size())) >=
           share * static_cast<double>(sleepers.free);
  }
  /// Whether a watched particle wakes those that it touches.
  static bool stirs(const Sleepers<S>& sleepers, const S& state, Index i, Scalar dt) {
    const Scalar most = sleepers.speed() * std::abs(dt) * static_cast<Scalar>(sleepers.options.every);
    return !sleepers.is_slow(state, i) || !((state.r.col(i) - sleepers[i].rest).norm() < most);
  }
  /// Whether the two of an edge act on each other now or within a step: spheres within a hundredth of their radii, or that may touch
  /// before they have moved by 2|v| Δt.
  [[nodiscard]] static bool acts(const S& y, Index i, const Edge& edge, Scalar dt) {
    if (!edge.mark || y.radius().size() != y.size()) return true;
    const Index j = edge.other;
    const Scalar radii = y.radius()[i] + y.radius()[j];
    const Scalar reach = radii * Scalar(1.01) + 2 * std::abs(dt) * (y.v.col(i).norm() + y.v.col(j).norm());
    return !(y.box().nearest(y.r.col(i) - y.r.col(j)).squaredNorm() >= reach * reach);
  }
  static void wake_by(Sleepers<S>& sleepers, const S& state, Index i, const Edge& edge, Scalar dt) {
    if (sleepers[edge.other].is_asleep() && acts(state, i, edge, dt)) sleepers.wake(edge.other, Kind::watched);
  }
  void find_frontier(const Sleepers<S>& sleepers) {
    frontier_.clear();
    if (sleepers.report.asleep == 0 || !graph_.is_of(sleepers.size())) return;
    for (const std::int32_t i : disturbing_)
      for (const Edge& edge : graph_.of(i))
        if (sleepers[edge.other].is_asleep()) frontier_.emplace_back(i, edge);
  }

  /// Particles came or went. The graph is still that of the step before.
  void match(Sleepers<S>& sleepers, const S& state) const {
    std::vector<Sleeper> now(static_cast<std::size_t>(state.size()));
    std::vector<std::int64_t> ids = state.id();  // nothing changes before there is memory for all
    const auto now_at = number_by_id(ids), was_at = number_by_id(sleepers.id);
    for (Index old = 0; sleepers.report.asleep > 0 && old < sleepers.size(); ++old)
      if (now_at(sleepers.id[static_cast<std::size_t>(old)]) < 0) wake_beside(sleepers, old);
    for (std::size_t k = 0; k < ids.size(); ++k) {
      const auto to = static_cast<Index>(k);
      const Index old = was_at(ids[k]);
      if (old < 0) {
        now[k].rest = now[k].sample = state.r.col(to), now[k].since = sleepers.clock;
        now[k].velocity = state.v.col(to), now[k].spin = sleepers.spin_of(state, to);
        continue;
      }
      now[k] = sleepers[old];
      // A fingerprint that doesn't fit, because the particle was edited, is kept: so that this is noticed under the new index.
      if (now[k].seen == ParticleFingerprint<S>::of(state, to, old))
        now[k].seen = ParticleFingerprint<S>::of(state, to);
    }
    sleepers.all = std::move(now), sleepers.id = std::move(ids);
  }
  /// Notes where a particle is held, and whether it moves.
  static void hold(Sleepers<S>& sleepers, const S& state, Index i) {
    Sleeper& one = sleepers[i];
    one.kind = Kind::held;
    one.moves = Sleepers<S>::moves(state, i);
    one.seen = ParticleFingerprint<S>::of(state, i);
    one.rest = state.r.col(i);
  }

  PairGraph<bool> graph_;  // particles that may act on each other; marked: by touch alone
  std::int64_t pair_changes_ = -1;
  std::vector<Meeting> late_;      // late pairs, from both ends
  std::vector<Meeting> frontier_;  // one awake, or a support that moves, and a sleeper
  std::vector<std::int32_t> watched_, disturbing_, tired_;
};

}}  // namespace phistep::PHISTEP_ABI
