/// @file
/// The pairs that are computed while some bodies are left out: all but those of two that are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "phistep/contacts/contact_pairs.hpp"
#include "phistep/core/version.hpp"
#include "phistep/state/active_set.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Slots of pairs, ascending by the pairs' numbers, and beyond the last some that may be read: a pack more.
struct PairRange {
  const std::int32_t *first = nullptr, *second = nullptr;
  const std::int32_t* place = nullptr;  ///< the pairs' numbers; null: 0, 1, 2 …
  std::size_t count = 0;

  [[nodiscard]] std::int32_t number(std::size_t p) const {
    return place == nullptr ? static_cast<std::int32_t>(p) : place[p];
  }
};

/// A workspace, its buffers serve again.
class ComputedPairs {
 public:
  /// Of these pairs those with somebody of the set; null: all. Worked out once for pairs and a set.
  template <class Scalar>
  [[nodiscard]] PairRange of(const ContactPairs<Scalar>& pairs, const ActiveSet* active) {
    if (active == nullptr) return {pairs.first.data(), pairs.second.data(), nullptr, pairs.places()};
    know(pairs, *active);
    return {first_.data(), second_.data(), place_.data(), place_.size() - ContactPairs<Scalar>::padding};
  }
  template <class Scalar>
  void know(const ContactPairs<Scalar>& pairs, const ActiveSet& active) {
    if (pairs_ != pairs.number || set_ != active.number()) find(pairs, active);
  }
  /// The slots of the bodies in those pairs, ascending; and those of the others that are held, and may move all the same.
  [[nodiscard]] const std::vector<std::int32_t>& slots() const { return slots_; }
  [[nodiscard]] const std::vector<std::int32_t>& held() const { return held_; }

 private:
  template <class Scalar>
  void find(const ContactPairs<Scalar>& pairs, const ActiveSet& active) {
    pairs_ = set_ = 0;
    const std::size_t n = pairs.bodies.size(), most = pairs.first.size();
    is_.resize(n);
    for (std::size_t s = 0; s < n; ++s) is_[s] = active.has(pairs.bodies.particle[s]) ? 1 : 0;
    is_met_ = is_;
    for (auto* array : {&first_, &second_, &place_})
      if (array->size() < most) array->resize(most);
    std::size_t found = 0;
    for (std::size_t s = 0; s < n; ++s) {
      const std::uint8_t all = is_[s];
      for (std::int32_t p = pairs.row[s]; p < pairs.row[s + 1]; ++p) {
        const std::int32_t other = pairs.second[static_cast<std::size_t>(p)];
        // Written, and kept only if it is one: no branch.
        first_[found] = static_cast<std::int32_t>(s), second_[found] = other, place_[found] = p;
        const auto is = static_cast<std::uint8_t>(all | is_[static_cast<std::size_t>(other)]);
        found += is;
        is_met_[s] |= is;
        is_met_[static_cast<std::size_t>(other)] |= is;
      }
    }
    for (auto* array : {&first_, &second_, &place_}) {
      array->resize(found);
      array->resize(found + ContactPairs<Scalar>::padding, 0);
    }
    slots_.clear(), held_.clear();
    for (std::size_t s = 0; s < n; ++s)
      if (is_met_[s] != 0) slots_.push_back(static_cast<std::int32_t>(s));
      else if (!(pairs.bodies.inverse_mass[s] > Scalar{0})) held_.push_back(static_cast<std::int32_t>(s));
    pairs_ = pairs.number, set_ = active.number();
  }

  std::vector<std::int32_t> first_, second_, place_, slots_, held_;
  std::vector<std::uint8_t> is_, is_met_;  // by slot: in the set; in a pair
  std::uint64_t pairs_ = 0, set_ = 0;
};

}  // namespace phistep::inline PHISTEP_ABI
