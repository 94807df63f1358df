/// @file
/// The active set: the particles whose forces are computed. The others keep their velocities, and so stay where they are if
/// they are at rest, as sleepers are.
///
/// It reaches every pass over particles with the masses (particles/bodies/body.hpp), which a force's view has: active_set(y). Another set
/// needs no new body, list or spring; what was worked out for one is known by its number.
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Some of the particles, as flags and as a list.
class ActiveSet {
 public:
  /// @param flags   one a particle, 0: left out
  /// @param number  another set, another number; > 0
  void assign(const std::vector<std::uint8_t>& flags, std::uint64_t number) {
    flags_ = flags;
    number_ = number;
    list_.clear();
    const std::size_t n = flags.size();
    for (std::size_t i = 0; i < n; ++i) {
      std::uint64_t eight = 0;  // passed over at once where none of them is in the set
      while (i + 8 <= n && (std::memcpy(&eight, &flags[i], 8), eight == 0)) i += 8;
      if (i < n && flags[i] != 0) list_.push_back(static_cast<std::int32_t>(i));
    }
  }
  [[nodiscard]] bool has(Eigen::Index i) const { return flags_[static_cast<std::size_t>(i)] != 0; }
  /// Their indices, ascending.
  [[nodiscard]] const std::vector<std::int32_t>& list() const { return list_; }
  /// Number of all particles, left out or not.
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(flags_.size()); }
  [[nodiscard]] std::uint64_t number() const { return number_; }

 private:
  std::vector<std::uint8_t> flags_;
  std::vector<std::int32_t> list_;
  std::uint64_t number_ = 0;
};

/// What is known of the particles outside the active set.
struct LeftOut {
  /// As long as this number stays the same, a particle outside the set has not moved, unless it is in `moving` or has just left
  /// the set. 0: nothing is known.
  std::uint64_t number = 0;
  std::vector<std::int32_t> moving{};  ///< particles outside the set whose velocity isn't 0

  friend bool operator==(const LeftOut&, const LeftOut&) = default;
};

/// f(i, joined) for each particle that is in one of two ascending lists only; joined: in `now`.
void for_each_change(const std::vector<std::int32_t>& before, const std::vector<std::int32_t>& now, auto&& f) {
  auto b = before.begin();
  for (const std::int32_t i : now) {
    for (; b != before.end() && *b < i; ++b) f(*b, false);
    if (b != before.end() && *b == i) ++b;
    else f(i, true);
  }
  for (; b != before.end(); ++b) f(*b, false);
}

/// A term of a force that leaves the forces on particles outside the active set as they are, so that they need not be set to
/// zero: it says `static constexpr bool computes_active_only = true`.
template <class F>
inline constexpr bool computes_active_only = requires {
  requires F::computes_active_only;
};

/// The particles of a force's view that are computed; null: all.
[[nodiscard]] const ActiveSet* active_set(const auto& y) {
  if constexpr (requires { y.mass.active(); }) return y.mass.active();
  else return nullptr;
}
/// The particles left out, of a force's view that has an active set.
[[nodiscard]] const LeftOut& left_out(const auto& y) { return y.mass.left_out; }
[[nodiscard]] inline std::uint64_t number_of(const ActiveSet* set) { return set == nullptr ? 0 : set->number(); }

/// A force's view of particles, which have properties: not of another motion.
template <class View>
concept HasBody = requires(const View& y) {
  y.body;
};
/// A view of particles with angular velocities.
template <class View>
concept HasSpin = requires(const View& y) {
  y.omega;
};
/// Whether particle i is held still. Only Particles can hold some: in any other motion none is.
[[nodiscard]] bool is_still(const auto& y, [[maybe_unused]] Eigen::Index i) {
  if constexpr (HasBody<decltype(y)>) return y.body.is_still(i);
  else return false;
}

}}  // namespace phistep::PHISTEP_ABI
