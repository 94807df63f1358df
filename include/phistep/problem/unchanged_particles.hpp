/// @file
/// A step that changes a few particles writes those, and no others: of particles outside the active set (state/active_set.hpp)
/// the workspace beside the state has the same numbers as the state, so that the commit is still a swap of arrays.
///
/// That they are the same, and so that nobody has edited them, is looked up by one pass over the state, and by none where the
/// caller says that it is unedited. The pass takes a fingerprint of all numbers (state/particle_fingerprint.hpp), a sum; less the
/// terms of the particles that the step changes it is that of the others.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/problem/origin.hpp"
#include "phistep/state/active_set.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/body.hpp"
#include "phistep/state/particle_fingerprint.hpp"

namespace phistep::inline PHISTEP_ABI {

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

  /// The particles that a step from y changes, `next` then has the others; null: any. They stay the same until end_step.
  [[nodiscard]] const std::vector<std::int32_t>* find(const ActiveSet* active, const Plain& y, Plain& next) {
    if (only_ != nullptr || active == nullptr) return only_;
    if (10 * static_cast<Index>(active->list().size()) >= 9 * active->size()) return nullptr;
    if (was_same_) follow(*active, y, next);
    const bool looks = origin_ == Origin::unknown;
    const std::uint64_t seen = looks ? hash(*active, y) : 0;
    if (!was_same_ || (looks && !(knows_hash_ && seen == hash_))) {
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
  /// The same, where they were found in this step.
  [[nodiscard]] const std::vector<std::int32_t>* found() const { return only_; }
  [[nodiscard]] const LeftOut& left_out() const { return left_out_; }

 private:
  [[nodiscard]] static bool moves(const Plain& y, Index i) { return (velocity_of<S>(y).col(i).array() != 0).any(); }
  /// Of the particles that stay as they are.
  [[nodiscard]] std::uint64_t hash(const ActiveSet& active, const Plain& y) const {
    return ParticleFingerprint<S>::without(y, active.list(), left_out_.moving);
  }
  /// Nothing was known of those that are left out.
  void take(const ActiveSet& active, const Plain& y) {
    left_out_.number = next_body_serial();
    left_out_.moving.clear();
    for (Index i = 0; i < active.size(); ++i)
      if (!active.has(i) && moves(y, i)) left_out_.moving.push_back(static_cast<std::int32_t>(i));
    list_ = active.list();
    set_ = active.number();
  }
  /// From the set of the step before to this one.
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
    list_ = active.list();
    set_ = active.number();
  }

  LeftOut left_out_;
  std::vector<std::int32_t> list_, changing_;        // of the last set; of it and of those that move
  const std::vector<std::int32_t>* only_ = nullptr;  // during a step
  Origin origin_ = Origin::unknown;                  // likewise
  bool was_same_ = false, is_same_ = false;          // before this step, before the next one
  bool knows_hash_ = false;
  std::uint64_t set_ = 0, hash_ = 0;
};

}  // namespace phistep::inline PHISTEP_ABI
