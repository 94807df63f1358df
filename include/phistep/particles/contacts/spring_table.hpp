/// @file
/// The springs of all contacts at one time: whose they are, and their lengths.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Sorted by place.
/// @tparam Number  of a place: a pair's, or that of a wall and a body
/// @tparam keeps_grip  of a law whose springs stiffen with the overlap
template <class Real, class Number = std::int32_t, bool keeps_grip = false>
struct SpringTable {
  using Scalar = Real;
  using Place = Number;
  /// One array a component, with numbers to spare for a whole pack. Behind the last contact stands one that is
  /// unstretched: what a new contact finds.
  struct Lengths {
    std::array<std::vector<Scalar>, 3> x;
    void resize(std::size_t n) {
      for (auto& a : x) resize_with_spare(a, n);
    }
    /// Of one contact; 0 where none are kept.
    [[nodiscard]] Triple<Scalar> operator[](std::size_t c) const {
      if (x[0].empty()) return {};
      return {x[0][c], x[1][c], x[2][c]};
    }
    void set(std::size_t c, const Triple<Scalar>& to) { x[0][c] = to.x, x[1][c] = to.y, x[2][c] = to.z; }
    /// Loads the springs of the contacts from[0], from[1] …
    template <class P>
    [[nodiscard]] Triple<P> load(const std::int32_t* from) const {
      // Mostly the same contacts touch as before, and stand in the same order.
      bool in_line = true;
      for (int l = 1; l < P::width; ++l) in_line &= from[l] == from[0] + l;
      const auto at = [&](const std::vector<Scalar>& a) {
        return in_line ? P::load(&a[static_cast<std::size_t>(from[0])]) : P::gather(a.data(), from);
      };
      return {at(x[0]), at(x[1]), at(x[2])};
    }
    /// May write behind the last contact, where others follow or none.
    template <class P>
    void store(const Triple<P>& lengths, std::size_t c) {
      lengths.x.store(&x[0][c]);
      lengths.y.store(&x[1][c]);
      lengths.z.store(&x[2][c]);
    }
    void archive(auto& ar) { ar("x", x); }
  };
  static constexpr std::size_t padding = 32;

  std::vector<Place> place;                                          ///< of each contact, ascending
  Lengths slip, roll;                                                ///< ξ, ψ; roll may be empty
  [[no_unique_address]] Only<keeps_grip, std::vector<Scalar>> grip;  ///< a

  [[nodiscard]] std::size_t size() const { return place.size(); }
  [[nodiscard]] bool rolls() const { return !roll.x[0].empty(); }
  void resize(std::size_t contacts, bool with_roll) {
    resize_with_spare(place, contacts);
    slip.resize(contacts + padding);
    roll.resize(with_roll ? contacts + padding : 0);
    if constexpr (keeps_grip) resize_with_spare(grip, contacts + padding);
  }
  [[nodiscard]] ContactSprings<Scalar> operator[](std::size_t c) const {
    ContactSprings<Scalar> springs{slip[c], roll[c]};
    if constexpr (keeps_grip) springs.grip = grip[c];
    return springs;
  }
  void set(std::size_t c, const ContactSprings<Scalar>& springs) {
    slip.set(c, springs.slip);
    if (rolls()) roll.set(c, springs.roll);
    if constexpr (keeps_grip) grip[c] = springs.grip;
  }
  /// What stands behind the last contact.
  void close() {
    for (auto* lengths : {&slip, &roll})
      for (auto& x : lengths->x)
        if (!x.empty()) std::fill(x.begin() + static_cast<std::ptrdiff_t>(size()), x.end(), Scalar{0});
    if constexpr (keeps_grip) std::fill(grip.begin() + static_cast<std::ptrdiff_t>(size()), grip.end(), Scalar{0});
  }
  void archive(auto& ar) {
    ar("place", place, "slip", slip, "roll", roll);
    if constexpr (keeps_grip) {
      ar("grip", grip);
      ar.check(grip.size() == slip.x[0].size() && all_finite(grip.data(), static_cast<std::ptrdiff_t>(grip.size())));
    }
    for (const auto& x : slip.x) ar.check(x.size() == size() + padding || (size() == 0 && x.empty()));
    for (const auto& x : roll.x) ar.check(x.size() == (rolls() ? slip.x[0].size() : 0));
    ar.check(std::is_sorted(place.begin(), place.end()) && (place.empty() || place.front() >= 0));
    for (const auto* lengths : {&slip, &roll})
      for (const auto& x : lengths->x) {
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

/// The force of the contacts c, c + 1, … of a pack, from springs of the table before, which stand at from[0], from[1], …, to
/// those after.
/// @param elapsed  [time] since `before` was known
template <bool spins, bool rolls, class Law, class P, class Table>
[[nodiscard]] ContactForce<P> contact_force(const ContactNumbers<P>& numbers, const ContactPoint<P>& at,
                                            typename Table::Scalar elapsed, const Table& before,
                                            const std::int32_t* from, Table& after, std::size_t c) {
  ContactSprings<P> springs{before.slip.template load<P>(from), {}};
  if constexpr (rolls) springs.roll = before.roll.template load<P>(from);
  if constexpr (stiffens<Law>) springs.grip = P::gather(before.grip.data(), from);
  const ContactForce<P> f = contact_force<spins, rolls, Law>(numbers, at, P(elapsed), springs);
  after.slip.store(springs.slip, c);
  if constexpr (rolls) after.roll.store(springs.roll, c);
  if constexpr (stiffens<Law>) springs.grip.store(&after.grip[c]);
  return f;
}

/// Springs on their way from one table to another, where the set that is computed or the list of pairs changes. A workspace.
template <class Table>
class CarriedSprings {
  using Scalar = typename Table::Scalar;
  using Springs = ContactSprings<Scalar>;

 public:
  /// No two of one place.
  void add(typename Table::Place place, const Springs& springs) { carried_.push_back({place, springs}); }
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
      table.place[c] = carried_[c].place;
      table.set(c, carried_[c].springs);
    }
    table.close();
    carried_.clear();
    in_order_ = 0;
  }

 private:
  struct Carried {
    typename Table::Place place;
    Springs springs;
  };
  static bool is_before(const Carried& a, const Carried& b) { return a.place < b.place; }
  std::vector<Carried> carried_;
  std::size_t in_order_ = 0;  // of these, ascending
};

}}  // namespace phistep::PHISTEP_ABI
