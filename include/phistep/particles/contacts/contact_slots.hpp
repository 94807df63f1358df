/// @file
/// Bodies in slots, in cache order; which of their pairs are computed, and whether one has moved too far for the list of pairs.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/linear/network/node_order.hpp"
#include "phistep/particles/contacts/contact_pairs.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The pairs that are computed while some bodies are left out: those with a body in the active set. A workspace: its buffers serve
/// again. A bit for each pair says whether it is computed; another set changes the bits of those bodies' pairs that joined or left.
template <class Scalar>
class ComputedPairs {
  using Pairs = ContactPairs<Scalar>;

 public:
  /// The pairs with at least one body in the set that was noted last.
  [[nodiscard]] PairRange range() const {
    return {first_.data(), second_.data(), place_.data(), place_.size() - Pairs::padding};
  }
  /// Notes a set, with work once for a list of pairs and a set.
  void update(const ContactPlaces<Scalar>& places, const ActiveSet& active) {
    const auto& pairs = *places.pairs;
    if (pairs_ == pairs.number && late_ == places.number && set_ == active.number()) return;
    const bool same_pairs = pairs_ == pairs.number;
    pairs_ = 0;  // if memory is short
    if (!same_pairs) begin(pairs);
    before_ = same_pairs ? set_ : 0;
    bits_before_.swap(pair_bits_);
    pair_bits_.assign(bits_before_.size(), 0);
    for (const std::int32_t i : active.list())
      for (const auto& edge : pairs_of_.of(pairs.bodies.slot[static_cast<std::size_t>(i)]))
        set(pair_bits_, static_cast<std::size_t>(edge.mark));
    collect(places, active);
    set_ = active.number();
    late_ = places.number;
    pairs_ = pairs.number;
  }
  /// The slots of the bodies in those pairs, ascending.
  [[nodiscard]] const std::vector<std::int32_t>& slots() const { return slots_; }
  [[nodiscard]] bool has_slot(std::size_t slot) const { return has(slot_bits_, slot); }
  [[nodiscard]] bool has_pair(std::int32_t place) const {
    if (const auto p = static_cast<std::size_t>(place); p < count_) return has(pair_bits_, p);
    return std::binary_search(late_places_.begin(), late_places_.end(), place);
  }
  /// Pairs, ascending, that are computed now and were not for the set of that number; null: not known.
  [[nodiscard]] const std::vector<std::int32_t>* joined_since(std::uint64_t set) const {
    return before_ != 0 && before_ == set ? &joined_ : nullptr;
  }
  /// Slots that the set before had in its pairs, and that are in none now.
  [[nodiscard]] const std::vector<std::int32_t>& dropped() const { return dropped_; }

 private:
  using Bits = std::vector<std::uint64_t>;
  [[nodiscard]] static bool has(const Bits& bits, std::size_t i) { return (bits[i / 64] >> (i % 64) & 1) != 0; }
  static void set(Bits& bits, std::size_t i) { bits[i / 64] |= std::uint64_t{1} << (i % 64); }
  /// f(i) for each bit of a word, ascending
  static void for_each_bit(std::uint64_t word, std::size_t index, auto&& f) {
    for (; word != 0; word &= word - 1)
      f(static_cast<std::int32_t>(64 * index + static_cast<std::size_t>(std::countr_zero(word))));
  }

  /// Another list of pairs: none is marked.
  void begin(const Pairs& pairs) {
    count_ = pairs.places();
    slots_.clear(), late_places_.clear();
    pair_bits_.assign(count_ / 64 + 1, 0);
    slot_bits_.assign(pairs.bodies.size() / 64 + 1, 0);
    pairs_of_.build(static_cast<Eigen::Index>(pairs.bodies.size()), [&](auto&& f) {
      for (std::size_t p = 0; p < count_; ++p) f(pairs.first[p], pairs.second[p], static_cast<std::int32_t>(p));
    });
  }
  /// From bits to lists.
  void collect(const ContactPlaces<Scalar>& places, const ActiveSet& active) {
    const auto& pairs = *places.pairs;
    late_before_.swap(late_places_);
    late_places_.clear();
    const auto is_in = [&](std::int32_t s) { return active.has(pairs.bodies.particle[static_cast<std::size_t>(s)]); };
    for (const auto& pair : places.late)
      if (is_in(pair.first) || is_in(pair.second)) late_places_.push_back(pair.place);
    for (auto* list : {&first_, &second_, &place_, &joined_, &dropped_, &slots_}) list->clear();
    slot_bits_before_ = slot_bits_;
    std::fill(slot_bits_.begin(), slot_bits_.end(), 0);
    const auto put = [&](std::int32_t place, std::int32_t first, std::int32_t second) {
      first_.push_back(first), second_.push_back(second), place_.push_back(place);
      set(slot_bits_, static_cast<std::size_t>(first)), set(slot_bits_, static_cast<std::size_t>(second));
    };
    for (std::size_t w = 0; w < pair_bits_.size(); ++w) {
      for_each_bit(pair_bits_[w], w, [&](std::int32_t place) {
        put(place, pairs.first[static_cast<std::size_t>(place)], pairs.second[static_cast<std::size_t>(place)]);
      });
      for_each_bit(pair_bits_[w] & ~bits_before_[w], w, [this](std::int32_t place) { joined_.push_back(place); });
    }
    for (const std::int32_t place : late_places_) {
      const auto [first, second] = places.slots(place);
      put(place, first, second);
    }
    for (auto* array : {&first_, &second_, &place_}) array->resize(array->size() + Pairs::padding);
    std::set_difference(late_places_.begin(), late_places_.end(), late_before_.begin(), late_before_.end(),
                        std::back_inserter(joined_));
    for (const std::int32_t i : active.list())  // in no pair, and moving all the same
      set(slot_bits_, static_cast<std::size_t>(pairs.bodies.slot[static_cast<std::size_t>(i)]));
    for (std::size_t w = 0; w < slot_bits_.size(); ++w) {
      for_each_bit(slot_bits_[w], w, [this](std::int32_t slot) { slots_.push_back(slot); });
      for_each_bit(slot_bits_before_[w] & ~slot_bits_[w], w, [this](std::int32_t slot) { dropped_.push_back(slot); });
    }
  }

  std::vector<std::int32_t> first_, second_, place_, slots_, joined_, dropped_, late_places_, late_before_;
  PairGraph<std::int32_t> pairs_of_;  // of each slot, by their numbers
  Bits pair_bits_, slot_bits_, bits_before_, slot_bits_before_;
  std::uint64_t pairs_ = 0, late_ = 0, set_ = 0, before_ = 0;
  std::size_t count_ = 0;  // of places before the late ones
};

/// The numbers of each body that its contacts need side by side, four in each array. A workspace, its buffers serve again.
template <class Scalar>
struct ContactSlots {
  /// The user's order may be random: bodies are prefetched so many ahead.
  static constexpr std::size_t ahead = 16;

  std::vector<Scalar> position;  ///< x, y, z, R
  std::vector<Scalar> velocity;  ///< v, 1/R
  std::vector<Scalar> surface;   ///< R ω, 1/m

  /// False: a body has moved by half the skin since the pairs were found.
  /// @param computed  only the slots of these pairs are filled; null: all are
  [[nodiscard]] bool gather(const auto& y, const ContactPlaces<Scalar>& places, const ComputedPairs<Scalar>* computed) {
    const ContactPairs<Scalar>& pairs = *places.pairs;
    const Scalar* const from = origins(places);
    const std::size_t n = pairs.bodies.size();
    position.resize(4 * n), velocity.resize(4 * n), surface.resize(4 * n);
    const std::int32_t* const list = computed == nullptr ? nullptr : computed->slots().data();
    const std::size_t count = computed == nullptr ? n : computed->slots().size();
    Scalar largest = 0;
    PHISTEP_DETAIL_OMP("omp parallel for schedule(static) reduction(max : largest)")
    for (std::size_t k = 0; k < count; ++k) {
      const auto slot_of = [list](std::size_t p) { return list == nullptr ? p : static_cast<std::size_t>(list[p]); };
      if (k + ahead < count) fetch(y, pairs.bodies.particle[slot_of(k + ahead)]);
      const Scalar moved = fill(y, pairs, from, slot_of(k));
      largest = largest < moved ? moved : largest;  // a NaN touches nothing; its force becomes NaN
    }
    const Scalar limit = pairs.skin * pairs.skin / 4;
    moved_.clear();
    if (computed == nullptr) return largest <= limit;
    const auto look = [&](std::size_t s, Scalar least) {
      if (square_moved(y, pairs, from, s) > least) moved_.push_back(static_cast<std::int32_t>(s));
    };
    look_elsewhere(pairs, *computed, left_out(y), [&](std::size_t s) { look(s, limit); });
    if (largest <= limit && moved_.empty()) return true;
    // Those that have come half as far are soon due, too.
    for (const std::int32_t s : computed->slots()) look(static_cast<std::size_t>(s), limit / 4);
    std::sort(moved_.begin(), moved_.end());
    moved_.erase(std::unique(moved_.begin(), moved_.end()), moved_.end());
    return false;
  }
  /// Slots of bodies that have moved too far, or soon will have, where `gather` for some slots was false.
  [[nodiscard]] const std::vector<std::int32_t>& moved() const { return moved_; }

 private:
  template <class View>
  static constexpr int dim_of = std::remove_cvref_t<decltype(std::declval<View>().r)>::RowsAtCompileTime;

  static void fetch(const auto& y, Eigen::Index next) {
    prefetch(y.r.data() + dim_of<decltype(y)> * next);
    prefetch(y.v.data() + dim_of<decltype(y)> * next);
    if constexpr (HasSpin<decltype(y)>) prefetch(y.omega.data() + y.omega.rows() * next);
  }
  /// Where each slot's body was when its pairs were found, 3 a slot [length].
  [[nodiscard]] const Scalar* origins(const ContactPlaces<Scalar>& places) {
    const ContactPairs<Scalar>& pairs = *places.pairs;
    if (places.strays.empty()) return pairs.built_at.data();
    if (origins_of_[1] == places.number) return origin_.data();
    if (origins_of_[0] != pairs.number) origin_ = pairs.built_at, strays_.clear();
    origins_of_ = {pairs.number, 0};
    for (const std::int32_t s : strays_) std::copy_n(&pairs.built_at[at(s)], 3, &origin_[at(s)]);
    strays_.clear();
    for (const auto& stray : places.strays) {
      strays_.push_back(stray.slot);
      std::copy_n(stray.at.data(), 3, &origin_[at(stray.slot)]);
    }
    origins_of_[1] = places.number;
    return origin_.data();
  }
  [[nodiscard]] static std::size_t at(std::int32_t slot) { return 3 * static_cast<std::size_t>(slot); }
  [[nodiscard]] static Scalar square_moved(const auto& y, const ContactPairs<Scalar>& pairs, const Scalar* from,
                                           std::size_t s) {
    const Eigen::Index i = pairs.bodies.particle[s];
    Scalar moved = 0;
    for (int a = 0; a < dim_of<decltype(y)>; ++a) {
      const Scalar d = y.r(a, i) - from[3 * s + static_cast<std::size_t>(a)];
      moved += d * d;
    }
    return moved;
  }
  /// look(slot) for bodies outside those slots that may have moved: once for all of a list and a LeftOut::number, then for those that move,
  /// and those that have just left the slots.
  void look_elsewhere(const ContactPairs<Scalar>& pairs, const ComputedPairs<Scalar>& computed, const LeftOut& others,
                      auto&& look) {
    if (others.number == 0 || others.number != seen_left_out_ || pairs.number != seen_pairs_) {
      for (std::size_t s = 0; s < pairs.bodies.size(); ++s)
        if (!computed.has_slot(s)) look(s);
      seen_left_out_ = others.number, seen_pairs_ = pairs.number;
    } else {
      for (const std::int32_t i : others.moving)
        look(static_cast<std::size_t>(pairs.bodies.slot[static_cast<std::size_t>(i)]));
      for (const std::int32_t slot : computed.dropped()) look(static_cast<std::size_t>(slot));
    }
  }
  /// How far it has moved, squared.
  [[nodiscard, gnu::always_inline]] inline Scalar fill(const auto& y, const ContactPairs<Scalar>& pairs,
                                                       const Scalar* origins, std::size_t s) {
    const Eigen::Index i = pairs.bodies.particle[s];
    const Scalar radius = pairs.bodies.radius[s];
    Scalar* const x = &position[4 * s];
    Scalar* const v = &velocity[4 * s];
    Scalar* const u = &surface[4 * s];
    x[2] = v[2] = u[0] = u[1] = u[2] = 0;
    for (int a = 0; a < dim_of<decltype(y)>; ++a) x[a] = y.r(a, i), v[a] = y.v(a, i);
    if constexpr (HasSpin<decltype(y)>)
      for (Eigen::Index a = 0, n = y.omega.rows(); a < n; ++a) u[3 - n + a] = radius * y.omega(a, i);
    x[3] = radius;
    v[3] = pairs.bodies.inverse_radius[s];
    u[3] = pairs.bodies.inverse_mass[s];
    return square_moved(y, pairs, origins, s);
  }

  std::uint64_t seen_left_out_ = 0, seen_pairs_ = 0;  // the last ones for which all others were read
  std::vector<Scalar> origin_;                        // where there are strays
  std::array<std::uint64_t, 2> origins_of_{};         // pairs, late ones
  std::vector<std::int32_t> strays_, moved_;
};

}}  // namespace phistep::PHISTEP_ABI
