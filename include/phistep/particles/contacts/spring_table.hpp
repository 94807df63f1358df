/// @file
/// The springs of all contacts at one time: whose they are, and their lengths.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The springs of contacts, sorted by their contact's place.
/// @tparam Number  of a place: that of a pair, or wall and body in one
/// @tparam keeps_grip  `grip` is kept: springs stiffen with the overlap
template <class Real, class Number = std::int32_t, bool keeps_grip = false>
struct SpringTable {
  using Scalar = Real;
  using Place = Number;
  using Springs = ContactSprings<Scalar>;
  static constexpr std::size_t count = sizeof(Springs) / sizeof(Scalar), padding = 32;

  std::vector<Place> place;  ///< of each contact, ascending
  /// One array for each number of a ContactSprings, or none where it isn't kept, with some to spare for a whole pack. Behind the last contact
  /// stands one that is unstretched: what a new contact finds.
  std::array<std::vector<Scalar>, count> numbers;

  [[nodiscard]] static constexpr bool keeps(std::size_t k, bool with_roll) {
    return k < 3 || (k < 6 ? with_roll : keeps_grip);
  }
  [[nodiscard]] std::size_t size() const { return place.size(); }
  [[nodiscard]] bool rolls() const { return !numbers[3].empty(); }
  void resize(std::size_t contacts, bool with_roll) {
    resize_with_spare(place, contacts);
    for (std::size_t k = 0; k < count; ++k) resize_with_spare(numbers[k], keeps(k, with_roll) ? contacts + padding : 0);
  }
  [[nodiscard]] Springs operator[](std::size_t c) const {
    std::array<Scalar, count> its{};
    for (std::size_t k = 0; k < count; ++k)
      if (!numbers[k].empty()) its[k] = numbers[k][c];
    return std::bit_cast<Springs>(its);
  }
  void set(std::size_t c, const Springs& springs) {
    const auto its = std::bit_cast<std::array<Scalar, count>>(springs);
    for (std::size_t k = 0; k < count; ++k)
      if (!numbers[k].empty()) numbers[k][c] = its[k];
  }
  /// The springs of the contacts from[0], from[1] …
  template <bool with_roll, class P>
  [[nodiscard]] ContactSprings<P> load(const std::int32_t* from) const {
    // Mostly the same contacts touch as before, and stand in the same order.
    bool in_line = true;
    for (int l = 1; l < P::width; ++l) in_line &= from[l] == from[0] + l;
    std::array<P, count> its{};
    unrolled<count>([&](auto k) {
      if constexpr (keeps(k, with_roll))
        its[k] = in_line ? P::load(&numbers[k][static_cast<std::size_t>(from[0])]) : P::gather(numbers[k].data(), from);
    });
    return std::bit_cast<ContactSprings<P>>(its);
  }
  /// May write behind the last contact, where others follow or none.
  template <bool with_roll, class P>
  void store(const ContactSprings<P>& springs, std::size_t c) {
    const auto its = std::bit_cast<std::array<P, count>>(springs);
    unrolled<count>([&](auto k) {
      if constexpr (keeps(k, with_roll)) its[k].store(&numbers[k][c]);
    });
  }
  /// Fills the padding behind the last contact with zeros.
  void close() {
    for (auto& x : numbers)
      if (!x.empty()) std::fill(x.begin() + static_cast<std::ptrdiff_t>(size()), x.end(), Scalar{0});
  }
  void archive(auto& ar) {
    ar("place", place, "numbers", numbers);
    ar.check(std::is_sorted(place.begin(), place.end()) && (place.empty() || place.front() >= 0));
    ar.check(numbers[0].size() == size() + padding || (size() == 0 && numbers[0].empty()));
    for (std::size_t k = 0; k < count; ++k) {
      const auto& x = numbers[k];
      ar.check(x.size() == (keeps(k, rolls()) ? numbers[0].size() : 0));
      ar.check(all_finite(x.data(), static_cast<std::ptrdiff_t>(x.size())));
      for (std::size_t c = size(); c < x.size(); ++c) ar.check(x[c] == Scalar{0});
    }
  }
};

/// Where the springs of places stand in a table, asked for one after the other, ascending from `first`: behind the last
/// contact, where springs are unstretched, for a place that is not in the table.
template <class Place>
[[nodiscard]] auto spring_finder(const std::vector<Place>& places, Place first) {
  const auto known = static_cast<std::int32_t>(places.size());
  auto at = static_cast<std::int32_t>(std::lower_bound(places.begin(), places.end(), first) - places.begin());
  return [known, at, place_of = places.data()](Place place) mutable {
    while (at < known && place_of[at] < place) ++at;
    return at < known && place_of[at] == place ? at : known;
  };
}

/// Springs on their way from one table to another, where the set that is computed or the list of pairs changes. A workspace.
template <class Table>
class CarriedSprings {
  using Place = typename Table::Place;
  using Springs = typename Table::Springs;
  using Carried = std::pair<Place, Springs>;

 public:
  /// No two of one place.
  void add(Place place, const Springs& springs) { carried_.emplace_back(place, springs); }
  /// Those added since the last call were ascending by place.
  void end_run() {
    const auto middle = carried_.begin() + static_cast<std::ptrdiff_t>(in_order_);
    if (middle != carried_.begin() && middle != carried_.end() && !is_before(*std::prev(middle), *middle))
      std::inplace_merge(carried_.begin(), middle, carried_.end(), is_before);
    in_order_ = carried_.size();
  }
  /// @param rolls    whether there are springs of rolling
  void lay_into(Table& table, bool rolls) {
    if (in_order_ < carried_.size()) std::sort(carried_.begin(), carried_.end(), is_before);
    table.resize(carried_.size(), rolls);
    for (std::size_t c = 0; c < carried_.size(); ++c) {
      table.place[c] = carried_[c].first;
      table.set(c, carried_[c].second);
    }
    table.close();
    carried_.clear();
    in_order_ = 0;
  }

 private:
  static bool is_before(const Carried& a, const Carried& b) { return a.first < b.first; }
  std::vector<Carried> carried_;
  std::size_t in_order_ = 0;  // of these, ascending
};

}}  // namespace phistep::PHISTEP_ABI
