/// @file
/// The springs of all contacts at one time: whose they are, and their lengths.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "phistep/base/machine/scratch.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Sorted by place.
/// @tparam Number  of a place: a pair's, or that of a wall and a body
template <class Real, class Number = std::int32_t>
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
    /// Of the contacts from[0], from[1] …
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

  std::vector<Place> place;  ///< of each contact, ascending
  Lengths slip, roll;        ///< ξ, ψ; roll may be empty

  [[nodiscard]] std::size_t size() const { return place.size(); }
  [[nodiscard]] bool rolls() const { return !roll.x[0].empty(); }
  void resize(std::size_t contacts, bool with_roll) {
    resize_with_spare(place, contacts);
    slip.resize(contacts + padding);
    roll.resize(with_roll ? contacts + padding : 0);
  }
  /// What stands behind the last contact.
  void close() {
    for (auto* lengths : {&slip, &roll})
      for (auto& x : lengths->x)
        if (!x.empty()) std::fill(x.begin() + static_cast<std::ptrdiff_t>(size()), x.end(), Scalar{0});
  }
  void archive(auto& ar) {
    ar("place", place, "slip", slip, "roll", roll);
    for (const auto& x : slip.x) ar.check(x.size() == size() + padding || (size() == 0 && x.empty()));
    for (const auto& x : roll.x) ar.check(x.empty() || x.size() == slip.x[0].size());
    for (const auto& x : roll.x) ar.check(x.size() == roll.x[0].size());
    ar.check(std::is_sorted(place.begin(), place.end()) && (place.empty() || place.front() >= 0));
    for (const auto* lengths : {&slip, &roll})
      for (const auto& x : lengths->x) {
        ar.check(all_finite(x.data(), static_cast<std::ptrdiff_t>(x.size())));
        for (std::size_t c = size(); c < x.size(); ++c) ar.check(x[c] == Scalar{0});
      }
  }
};

/// Where the springs of ascending places stand in a table.
template <class Place>
class SpringFinder {
 public:
  /// @param first  none of the places is less
  SpringFinder(const std::vector<Place>& places, Place first)
      : places_{places.data()},
        known_{static_cast<std::int32_t>(places.size())},
        at_{static_cast<std::int32_t>(std::lower_bound(places.begin(), places.end(), first) - places.begin())} {}
  /// Behind the last contact, where springs are unstretched, for a place that is not in the table.
  [[nodiscard]] std::int32_t operator()(Place place) {
    while (at_ < known_ && places_[at_] < place) ++at_;
    return at_ < known_ && places_[at_] == place ? at_ : known_;
  }

 private:
  const Place* places_;
  std::int32_t known_, at_;
};

/// The force of the contacts c, c + 1, … of a pack, from springs of the table before, which stand at from[0], from[1], …, to
/// those after.
/// @param elapsed  [time] since `before` was known
template <bool spins, bool rolls, class Law, class P, class Table>
[[nodiscard]] ContactForce<P> contact_force(const ContactNumbers<P>& numbers, const ContactPoint<P>& at,
                                            typename Table::Scalar elapsed, const Table& before,
                                            const std::int32_t* from, Table& after, std::size_t c) {
  ContactSprings<P> springs{before.slip.template load<P>(from), {}};
  if constexpr (rolls) springs.roll = before.roll.template load<P>(from);
  const ContactForce<P> f = contact_force<spins, rolls, Law>(numbers, at, P(elapsed), springs);
  after.slip.store(springs.slip, c);
  if constexpr (rolls) after.roll.store(springs.roll, c);
  return f;
}

// How springs get from one table to the next where bodies, or the list of pairs, change.

/// Springs of contacts that are not computed for now, because both bodies are held still: kept until it moves again.
template <class Scalar>
struct DormantSprings {
  struct Contact {
    std::int64_t a, b;                 ///< identities of two bodies, or of a body and the number of its wall
    std::array<Scalar, 3> slip, roll;  ///< as a sees them
  };
  std::vector<Contact> contacts;
  void archive(auto& ar) {
    ar.columns("contacts", contacts, "a", &Contact::a, "b", &Contact::b, "slip", &Contact::slip, "roll",
               &Contact::roll);
    for (const Contact& one : contacts) ar.check(all_finite(one.slip.data(), 3) && all_finite(one.roll.data(), 3));
  }
};

/// Springs on their way into a new table, or to rest.
template <class Table>
class CarriedSprings {
  using Scalar = typename Table::Scalar;
  using Springs = ContactSprings<Scalar>;
  using Dormant = DormantSprings<Scalar>;

 public:
  /// f(a, b, springs) for those that lie dormant
  static void for_each(const Dormant& dormant, auto&& f) {
    const auto triple = [](const std::array<Scalar, 3>& x) { return Triple<Scalar>{x[0], x[1], x[2]}; };
    for (const auto& one : dormant.contacts) f(one.a, one.b, Springs{triple(one.slip), triple(one.roll)});
  }
  /// f(c, springs) for those of a table
  static void for_each(const Table& table, auto&& f) {
    for (std::size_t c = 0; c < table.size(); ++c) f(c, Springs{table.slip[c], table.roll[c]});
  }

  /// To places in any order.
  void carry_to(typename Table::Place place, const Springs& springs) { carried_.push_back({place, springs}); }
  void lay_down(std::int64_t a, std::int64_t b, const Springs& springs) {
    const auto array = [](const Triple<Scalar>& x) { return std::array<Scalar, 3>{x.x, x.y, x.z}; };
    asleep_.contacts.push_back({a, b, array(springs.slip), array(springs.roll)});
  }
  /// @param rolls    whether there are springs of rolling
  /// @param dormant  those known so far, or none; replaced where they change
  void finish(Table& table, bool rolls, std::shared_ptr<const Dormant>& dormant) {
    std::sort(carried_.begin(), carried_.end(), [](const Carried& a, const Carried& b) { return a.place < b.place; });
    table.resize(carried_.size(), rolls);
    for (std::size_t c = 0; c < carried_.size(); ++c) {
      table.place[c] = carried_[c].place;
      table.slip.set(c, carried_[c].springs.slip);
      if (rolls) table.roll.set(c, carried_[c].springs.roll);
    }
    table.close();
    if ((dormant && !dormant->contacts.empty()) || !asleep_.contacts.empty())
      dormant = std::make_shared<const Dormant>(std::move(asleep_));
  }

 private:
  struct Carried {
    typename Table::Place place;
    Springs springs;
  };
  std::vector<Carried> carried_;
  Dormant asleep_;
};

}}  // namespace phistep::PHISTEP_ABI
