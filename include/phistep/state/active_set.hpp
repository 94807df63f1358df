/// @file
/// Who is computed. Of the others no force is asked for, so that they go on as they are: at rest, where who sleeps is left out.
///
/// It reaches every pass over particles with the masses (state/body.hpp), which a force's view has: active_set(y). Another set
/// needs no new body, list or spring; what was worked out for one is known by its number.
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Some of the particles, as flags and as a list.
class ActiveSet {
 public:
  /// @param flags   one a particle, 0: left out
  /// @param number  another set, another number; > 0
  void assign(const std::vector<std::uint8_t>& flags, std::uint64_t number) {
    flags_ = flags;
    number_ = number;
    list_.clear();
    for (std::size_t i = 0; i < flags.size(); ++i)
      if (flags[i] != 0) list_.push_back(static_cast<std::int32_t>(i));
  }
  [[nodiscard]] bool has(Eigen::Index i) const { return flags_[static_cast<std::size_t>(i)] != 0; }
  /// Their indices, ascending.
  [[nodiscard]] const std::vector<std::int32_t>& list() const { return list_; }
  /// Of particles, left out or not.
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(flags_.size()); }
  [[nodiscard]] std::uint64_t number() const { return number_; }

 private:
  std::vector<std::uint8_t> flags_;
  std::vector<std::int32_t> list_;
  std::uint64_t number_ = 0;
};

/// Those of a force's view that are computed; null: all.
[[nodiscard]] const ActiveSet* active_set(const auto& y) {
  if constexpr (requires { y.mass.active(); }) return y.mass.active();
  else return nullptr;
}
[[nodiscard]] inline std::uint64_t number_of(const ActiveSet* set) { return set == nullptr ? 0 : set->number(); }

}  // namespace phistep::inline PHISTEP_ABI
