/// @file
/// The springs of all contacts at one time: whose they are, and their lengths.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
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

}}  // namespace phistep::PHISTEP_ABI
