/// @file
/// The pairs that are computed while some bodies are left out: those with a body in the active set.
///
/// A bit a pair says whether it is one of them. Another set changes the bits of the pairs of those bodies that joined it or
/// left it, and no others.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "phistep/base/state/active_set.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/contacts/contact_pairs.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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
  /// The pairs with at least one body in the set; null: all. Worked out once for a list of pairs and a set.
  template <class Scalar>
  [[nodiscard]] PairRange of(const ContactPairs<Scalar>& pairs, const ActiveSet* active) {
    if (active == nullptr) return {pairs.first.data(), pairs.second.data(), nullptr, pairs.places()};
    update(pairs, *active);
    return {first_.data(), second_.data(), place_.data(), place_.size() - ContactPairs<Scalar>::padding};
  }
  template <class Scalar>
  void update(const ContactPairs<Scalar>& pairs, const ActiveSet& active) {
    if (pairs_ == pairs.number && set_ == active.number()) return;
    const bool same_pairs = pairs_ == pairs.number;
    pairs_ = 0;  // if memory is short
    if (!same_pairs) begin(pairs);
    before_ = same_pairs ? set_ : 0;
    mark(pairs, active);
    collect(pairs);
    set_ = active.number();
    pairs_ = pairs.number;
  }
  /// The slots of the bodies in those pairs, ascending.
  [[nodiscard]] const std::vector<std::int32_t>& slots() const { return slots_; }
  [[nodiscard]] bool has_slot(std::size_t slot) const { return has(slot_bits_, slot); }
  [[nodiscard]] bool has_pair(std::int32_t place) const { return has(pair_bits_, static_cast<std::size_t>(place)); }
  /// Pairs, ascending, that are computed now and were not for the set of number before(); 0: not known for any.
  [[nodiscard]] const std::vector<std::int32_t>& joined() const { return joined_; }
  [[nodiscard]] std::uint64_t before() const { return before_; }
  /// Slots that the set before had in its pairs, and that are in none now.
  [[nodiscard]] const std::vector<std::int32_t>& dropped() const { return dropped_; }

 private:
  using Bits = std::vector<std::uint64_t>;
  [[nodiscard]] static bool has(const Bits& bits, std::size_t i) { return (bits[i / 64] >> (i % 64) & 1) != 0; }
  static void set(Bits& bits, std::size_t i) { bits[i / 64] |= std::uint64_t{1} << (i % 64); }
  static void unset(Bits& bits, std::size_t i) { bits[i / 64] &= ~(std::uint64_t{1} << (i % 64)); }
  /// f(i) for each bit of a word, ascending
  static void for_each_bit(std::uint64_t word, std::size_t index, auto&& f) {
    for (; word != 0; word &= word - 1)
      f(static_cast<std::int32_t>(64 * index + static_cast<std::size_t>(std::countr_zero(word))));
  }

  /// Another list of pairs: none is marked, and each slot's pairs with slots before it are looked up.
  template <class Scalar>
  void begin(const ContactPairs<Scalar>& pairs) {
    const std::size_t n = pairs.bodies.size(), count = pairs.places();
    list_.clear(), slots_.clear();
    is_.assign(n, 0);
    pair_bits_.assign(count / 64 + 1, 0);
    slot_bits_.assign(n / 64 + 1, 0);
    earlier_from_.assign(n + 1, 0);
    earlier_.resize(count);
    for (std::size_t p = 0; p < count; ++p) ++earlier_from_[static_cast<std::size_t>(pairs.second[p])];
    std::int32_t sum = 0;
    for (std::int32_t& from : earlier_from_) sum += from, from = sum;
    for (std::size_t p = count; p-- > 0;)
      earlier_[static_cast<std::size_t>(--earlier_from_[static_cast<std::size_t>(pairs.second[p])])] =
          static_cast<std::int32_t>(p);
  }
  /// f(pair, other slot) for the pairs of a slot
  template <class Scalar>
  void for_each_pair(const ContactPairs<Scalar>& pairs, std::size_t slot, auto&& f) const {
    for (auto p = static_cast<std::size_t>(pairs.row[slot]); p < static_cast<std::size_t>(pairs.row[slot + 1]); ++p)
      f(p, pairs.second[p]);
    for (std::int32_t k = earlier_from_[slot]; k < earlier_from_[slot + 1]; ++k) {
      const auto p = static_cast<std::size_t>(earlier_[static_cast<std::size_t>(k)]);
      f(p, pairs.first[p]);
    }
  }
  template <class Scalar>
  void mark(const ContactPairs<Scalar>& pairs, const ActiveSet& active) {
    bits_before_ = pair_bits_;
    const auto slot_of = [&](std::int32_t particle) {
      return static_cast<std::size_t>(pairs.bodies.slot[static_cast<std::size_t>(particle)]);
    };
    for_each_change(list_, active.list(), [&](std::int32_t i, bool joined) { is_[slot_of(i)] = joined ? 1 : 0; });
    for_each_change(list_, active.list(), [&](std::int32_t i, bool joined) {
      for_each_pair(pairs, slot_of(i), [&](std::size_t p, std::int32_t other) {
        if (joined) set(pair_bits_, p);
        else if (is_[static_cast<std::size_t>(other)] == 0) unset(pair_bits_, p);
      });
    });
    list_ = active.list();
  }
  /// From bits to lists.
  template <class Scalar>
  void collect(const ContactPairs<Scalar>& pairs) {
    std::size_t count = 0;
    for (const std::uint64_t word : pair_bits_) count += static_cast<std::size_t>(std::popcount(word));
    for (auto* array : {&first_, &second_, &place_}) array->resize(count + ContactPairs<Scalar>::padding);
    for (auto* array : {&first_, &second_, &place_})
      std::fill(array->begin() + static_cast<std::ptrdiff_t>(count), array->end(), 0);
    joined_.clear(), dropped_.clear();
    slot_bits_before_ = slot_bits_;
    std::fill(slot_bits_.begin(), slot_bits_.end(), 0);
    std::size_t at = 0;
    for (std::size_t w = 0; w < pair_bits_.size(); ++w) {
      for_each_bit(pair_bits_[w], w, [&](std::int32_t place) {
        const auto p = static_cast<std::size_t>(place);
        first_[at] = pairs.first[p], second_[at] = pairs.second[p], place_[at] = place;
        set(slot_bits_, static_cast<std::size_t>(first_[at])), set(slot_bits_, static_cast<std::size_t>(second_[at]));
        ++at;
      });
      for_each_bit(pair_bits_[w] & ~bits_before_[w], w, [this](std::int32_t place) { joined_.push_back(place); });
    }
    for (const std::int32_t i : list_)  // in no pair, and moving all the same
      set(slot_bits_, static_cast<std::size_t>(pairs.bodies.slot[static_cast<std::size_t>(i)]));
    slots_.clear();
    for (std::size_t w = 0; w < slot_bits_.size(); ++w) {
      for_each_bit(slot_bits_[w], w, [this](std::int32_t slot) { slots_.push_back(slot); });
      for_each_bit(slot_bits_before_[w] & ~slot_bits_[w], w, [this](std::int32_t slot) { dropped_.push_back(slot); });
    }
  }

  std::vector<std::int32_t> first_, second_, place_, slots_, joined_, dropped_;
  std::vector<std::int32_t> list_;                    // the set's particles
  std::vector<std::uint8_t> is_;                      // of each slot, whether its body is in the set
  std::vector<std::int32_t> earlier_, earlier_from_;  // pairs of each slot with slots before it
  Bits pair_bits_, slot_bits_, bits_before_, slot_bits_before_;
  std::uint64_t pairs_ = 0, set_ = 0, before_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
