/// @file
/// A step that changes few particles writes only those. The particles outside the active set (base/state/active_set.hpp) have the
/// same numbers in the state and in the workspace beside it, so that the commit is still a swap of arrays.
///
/// An edit of the state would break that. One pass over the state finds it by a fingerprint of the unchanged particles
/// (base/state/particle_fingerprint.hpp): the sum over all particles minus the terms of those that the step changes. The pass is
/// left out where the caller says that the state is unedited.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/particle_fingerprint.hpp"
#include "phistep/step/equation/origin.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State S>
class UnchangedParticles {
 public:
  using Plain = PlainState<S>;

  void begin_step(Origin origin) {
    origin_ = origin;
    was_same_ = std::exchange(is_same_, false);
    only_ = nullptr;
  }
  /// @param done  the step has become the state
  void end_step(bool done) { is_same_ = done && only_ != nullptr; }
  void forget() { is_same_ = knows_hash_ = false; }

  /// The particles that a step from y changes; `next` holds the others. Null: it may change all. Valid until end_step.
  [[nodiscard]] const std::vector<std::int32_t>* find(const ActiveSet* active, const Plain& y, Plain& next) {
    if (only_ != nullptr || active == nullptr) return only_;
    if (10 * static_cast<Index>(active->list().size()) >= 9 * active->size()) return nullptr;
    if (was_same_) follow(*active, y, next);
    const bool looks = origin_ == Origin::unknown;
    if (!was_same_ || (looks && !(knows_hash_ && hash(*active, y) == hash_))) {
      copy_blocks<S>(next, y);
      take(*active, y);
      knows_hash_ = looks;
      hash_ = looks ? hash(*active, y) : 0;
    }
    only_ = &active->list();
    if (!left_out_.moving.empty()) {
      changing_ = active->list();
      changing_.insert(changing_.end(), left_out_.moving.begin(), left_out_.moving.end());
      only_ = &changing_;
    }
    return only_;
  }
  /// What find() has returned in this step; null before.
  [[nodiscard]] const std::vector<std::int32_t>* found() const { return only_; }
  [[nodiscard]] const LeftOut& left_out() const { return left_out_; }

 private:
  [[nodiscard]] static bool moves(const Plain& y, Index i) { return (velocity_of<S>(y).col(i).array() != 0).any(); }
  /// Fingerprint of the particles that the step does not change.
  [[nodiscard]] std::uint64_t hash(const ActiveSet& active, const Plain& y) const {
    return ParticleFingerprint<S>::without(y, active.list(), left_out_.moving);
  }
  /// Records the active set, and which particles outside of it move, from nothing.
  void take(const ActiveSet& active, const Plain& y) {
    left_out_.number = next_serial();
    left_out_.moving.clear();
    for (Index i = 0; i < active.size(); ++i)
      if (!active.has(i) && moves(y, i)) left_out_.moving.push_back(static_cast<std::int32_t>(i));
    note(active);
  }
  /// Records the changes from the active set of the last step to this one.
  void follow(const ActiveSet& active, const Plain& y, Plain& next) {
    if (set_ == active.number()) return;
    auto& moving = left_out_.moving;
    for_each_change(list_, active.list(), [&](std::int32_t i, bool joined) {
      if (joined) {
        if (std::erase(moving, i) == 0) hash_ -= ParticleFingerprint<S>::of(y, i);
        return;
      }
      for_each_block([i](auto, auto& to, const auto& from) { to.col(i) = from.col(i); }, Blocks<S>::all(next),
                     Blocks<S>::all(y));
      if (moves(y, i)) moving.push_back(i);
      else hash_ += ParticleFingerprint<S>::of(y, i);
    });
    note(active);
  }
  void note(const ActiveSet& active) { list_ = active.list(), set_ = active.number(); }

  LeftOut left_out_;
  std::vector<std::int32_t> list_, changing_;        // the last active set; the same with the moving particles outside
  const std::vector<std::int32_t>* only_ = nullptr;  // during a step
  Origin origin_ = Origin::unknown;                  // likewise
  bool was_same_ = false, is_same_ = false;          // `next` has the unchanged particles: before, after this step
  bool knows_hash_ = false;
  std::uint64_t set_ = 0, hash_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
