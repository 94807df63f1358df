/// @file
/// The user's edits between two steps, and which sleeping particles they wake.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "phistep/base/archive/archive.hpp"
#include "phistep/base/numbers/fingerprint.hpp"
#include "phistep/base/state/particle_fingerprint.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/sleep/sleep_watch.hpp"
#include "phistep/particles/sleep/sleepers.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A particle whose numbers or properties were changed wakes; those beside a sleeper or a support that was moved, or is gone,
/// are watched.
template <class S>
class SleepEdits {
 public:
  using Kind = Sleeper::Kind;

  /// Other particles, or a new body. True where anything is other than before.
  bool adopt_bodies(Sleepers<S>& sleepers, SleepWatch<S>& watch, const S& state) {
    const auto& body = state.body();
    bool is_other = sleepers.id != state.id();
    if (is_other) {
      sleepers.match(state, [&] { wake_beside_the_erased(sleepers, watch, state); });
      watch.forget();
    }
    Writer box;
    box(body.box, body.inertia_factor);
    const auto scene = fingerprint(box.bytes().data(), static_cast<std::ptrdiff_t>(box.bytes().size()));
    if (std::exchange(scene_, scene) != scene) is_other = true, sleepers.wake_all();
    for (Index i = 0; i < state.size(); ++i) {
      Sleeper& one = sleepers[i];
      const std::uint64_t bits = bits_of(body, i);
      if (std::exchange(one.properties, bits) != bits) {
        is_other = true;
        if (one.is_asleep()) sleepers.wake(i, Kind::awake);
      }
      if (body.is_still(i) == (one.kind == Kind::held)) continue;
      is_other = true;
      if (body.is_still(i)) hold(sleepers, state, i);
      else one = Sleeper{.properties = bits, .since = sleepers.clock};
    }
    if (is_other) sleepers.count();
    watch.find_supports(sleepers);
    sleepers.changed = true;
    return is_other;
  }
  /// Whether a particle that rests isn't as it was: one pass over the state.
  /// @param computed  the active set
  [[nodiscard]] static bool are_any(const Sleepers<S>& sleepers, const SleepWatch<S>& watch, const S& state,
                                    const std::vector<std::int32_t>& computed) {
    const auto& supports = watch.moving_supports();
    if (std::any_of(supports.begin(), supports.end(), [&](Index i) { return !Sleepers<S>::moves(state, i); }))
      return true;
    return ParticleFingerprint<S>::without(state, computed, supports) != sleepers.seen;
  }
  /// Finds them.
  void find(Sleepers<S>& sleepers, SleepWatch<S>& watch, const S& state) {
    for (Index i = 0; i < state.size(); ++i) {
      Sleeper& one = sleepers[i];
      if (one.is_computed() || (one.rests() && one.seen == ParticleFingerprint<S>::of(state, i))) continue;
      if (one.is_asleep()) {
        watch.wake_beside(sleepers, i);
        sleepers.wake(i, Kind::awake);
      } else {
        const bool stays = (state.r.col(i).array() == sleepers.rest.col(i).array()).all();
        if (!stays && !one.moves) watch.wake_beside(sleepers, i);
        hold(sleepers, state, i);
      }
    }
    recount(sleepers, watch);
  }
  /// Notes anew where particles are held: edits of them were not looked for while no particle slept.
  void look_at_supports(Sleepers<S>& sleepers, SleepWatch<S>& watch, const S& state) {
    if (sleepers.free == sleepers.size()) return;
    for (Index i = 0; i < state.size(); ++i)
      if (sleepers[i].kind == Kind::held) hold(sleepers, state, i);
    recount(sleepers, watch);
  }
  void archive(auto& ar) { ar("scene", scene_); }

 private:
  static void recount(Sleepers<S>& sleepers, SleepWatch<S>& watch) {
    sleepers.count();
    watch.find_supports(sleepers);
    sleepers.changed = true;
  }
  /// Notes where a particle is held, and whether it moves.
  static void hold(Sleepers<S>& sleepers, const S& state, Index i) {
    Sleeper& one = sleepers[i];
    one.kind = Kind::held;
    one.moves = Sleepers<S>::moves(state, i);
    one.seen = ParticleFingerprint<S>::of(state, i);
    sleepers.rest.col(i) = state.r.col(i);
  }
  [[nodiscard]] static std::uint64_t bits_of(const auto& body, Index i) {
    const auto of = [i](const auto& column) { return column.size() == 0 ? 0 : static_cast<double>(column[i]); };
    const double all[] = {of(body.mass), of(body.radius), of(body.type), of(body.charge)};
    return fingerprint(all, 4);
  }
  /// The graph is still that of the step before, and so are the indices.
  static void wake_beside_the_erased(Sleepers<S>& sleepers, SleepWatch<S>& watch, const S& state) {
    if (sleepers.report.asleep == 0) return;
    std::size_t k = 0;
    for (std::size_t old = 0; old < sleepers.id.size(); ++old) {
      while (k < state.id().size() && state.id()[k] < sleepers.id[old]) ++k;
      if (k < state.id().size() && state.id()[k] == sleepers.id[old]) continue;
      watch.wake_beside(sleepers, static_cast<Index>(old));
    }
  }

  std::uint64_t scene_ = 0;  // fingerprint of the box and what else all particles share
};

}}  // namespace phistep::PHISTEP_ABI
