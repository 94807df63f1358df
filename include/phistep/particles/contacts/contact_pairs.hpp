/// @file
/// The pairs of bodies that touch or soon may, each once, in cache order.
///
/// Particles stand in slots sorted by place; pair p joins slots first[p] < second[p], and pairs are sorted by both. A body
/// held still has no pair with another one.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "phistep/base/machine/serial.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/bodies/body.hpp"
#include "phistep/particles/contacts/contact_bodies.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"
#include "phistep/particles/contacts/spring_table.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Scalar>
struct ContactPairs {
  static constexpr std::size_t padding = 16;  ///< entries beyond the last pair, readable: a pack more

  ContactBodies<Scalar> bodies;
  std::vector<std::int32_t> first, second;  ///< slots, of each pair and of the padding
  std::vector<std::int32_t> row;            ///< pairs of slot s: row[s] … row[s + 1] − 1
  std::vector<Scalar> built_at;             ///< positions when the pairs were found, 3 a slot [length]
  Scalar skin = 0;                          ///< pairs within R_i + R_j + skin are here [length]
  Scalar period[3] = {0, 0, 0};             ///< 0: the axis is open [length]
  std::uint64_t number = next_serial();     ///< other pairs, another number

  [[nodiscard]] std::size_t places() const { return first.size() < padding ? 0 : first.size() - padding; }
  [[nodiscard]] bool has(std::int32_t place) const { return static_cast<std::size_t>(place) < places(); }
  /// The pair of two slots, or −1.
  [[nodiscard]] std::ptrdiff_t find(std::int32_t a, std::int32_t b) const {
    const auto begin = second.begin() + row[static_cast<std::size_t>(a)],
               end = second.begin() + row[static_cast<std::size_t>(a) + 1];
    const auto at = std::lower_bound(begin, end, b);
    return at != end && *at == b ? at - second.begin() : -1;
  }

  void archive(auto& ar) {
    ar("bodies", bodies, "first", first, "second", second, "row", row, "built_at", built_at, "skin", skin);
    ar("period_x", period[0], "period_y", period[1], "period_z", period[2]);
    const std::size_t n = bodies.size(), m = first.size();
    ar.check(second.size() == m && (n == 0 || row.size() == n + 1) && built_at.size() == 3 * n);
    ar.check(n == 0 || (m >= padding && row.front() == 0 && static_cast<std::size_t>(row.back()) == m - padding));
    ar.check(std::is_sorted(row.begin(), row.end()));
    // From where a position isn't a number, nothing would ever have moved.
    ar.check(all_finite(built_at.data(), static_cast<std::ptrdiff_t>(built_at.size())));
    ar.check(std::isfinite(skin) && all_finite(period, 3));
    for (const auto* slots : {&first, &second})
      for (const std::int32_t s : *slots) ar.check(s >= 0 && static_cast<std::size_t>(s) < std::max<std::size_t>(n, 1));
  }
};

/// Differences of two places, less the nearest multiple of each axis' period.
/// @tparam P  numbers or packs
template <class P>
class NearestImage {
 public:
  /// @param period  0 where the axis is open
  template <class Scalar>
  explicit NearestImage(const Scalar (&period)[3])
      : period_{period[0], period[1], period[2]}, inverse_{of(period[0]), of(period[1]), of(period[2])} {}
  [[nodiscard]] Triple<P> operator()(const Triple<P>& d) const {
    const auto nearest = [](P x, P period, P inverse) { return x - period * nearest_integer(x * inverse); };
    return {nearest(d.x, period_.x, inverse_.x), nearest(d.y, period_.y, inverse_.y),
            nearest(d.z, period_.z, inverse_.z)};
  }

 private:
  template <class Scalar>
  [[nodiscard]] static P of(Scalar period) {
    return P(period > 0 ? Scalar{1} / period : Scalar{0});
  }
  Triple<P> period_, inverse_;
};

/// Springs of the same contacts, found by the bodies' identities, in the places of other pairs. New ones begin unstretched.
/// Those of pairs that are listed no more because both bodies are held still lie dormant from then on, until one moves.
/// @param rolls        whether there are springs of rolling
/// @param same_bodies  the users' indices still mean the same bodies
/// @param dormant      those known so far, or none; replaced where they change
template <class Scalar>
void carry_springs(const ContactPairs<Scalar>& from, const SpringTable<Scalar>& old, const ContactPairs<Scalar>& to,
                   SpringTable<Scalar>& table, bool rolls, bool same_bodies,
                   std::shared_ptr<const DormantSprings<Scalar>>& dormant) {
  using Carried = CarriedSprings<SpringTable<Scalar>>;
  Carried carried;
  const auto is_still = [&to](std::int32_t slot) {
    return !(to.bodies.inverse_mass[static_cast<std::size_t>(slot)] > Scalar{0});
  };
  // Springs belong to the pair in the order of slots. The other way round ξ has the other sign; ψ, n × a turn, has two.
  const auto carry = [&](std::int32_t i, std::int32_t j, ContactSprings<Scalar> springs) {
    if (i < 0 || j < 0) return;
    if (i > j) std::swap(i, j), springs.slip = Scalar{-1} * springs.slip;
    const std::ptrdiff_t place = to.find(i, j);
    if (place >= 0) carried.carry_to(static_cast<std::int32_t>(place), springs);
    else if (is_still(i) && is_still(j))
      carried.lay_down(to.bodies.id[static_cast<std::size_t>(i)], to.bodies.id[static_cast<std::size_t>(j)], springs);
  };

  std::vector<std::int32_t> slot(from.bodies.size(), -1);  // where a slot's body stands now
  const bool has_dormant = dormant && !dormant->contacts.empty();
  if (!same_bodies || has_dormant) {
    const SlotsById by_id{to.bodies.id};
    for (std::size_t s = 0; s < slot.size(); ++s) slot[s] = by_id(from.bodies.id[s]);
    if (has_dormant)
      Carried::for_each(
          *dormant, [&](std::int64_t a, std::int64_t b, const auto& springs) { carry(by_id(a), by_id(b), springs); });
  } else {
    for (std::size_t s = 0; s < slot.size(); ++s)
      slot[s] = to.bodies.slot[static_cast<std::size_t>(from.bodies.particle[s])];
  }
  Carried::for_each(old, [&](std::size_t c, const auto& springs) {
    const auto p = static_cast<std::size_t>(old.place[c]);
    carry(slot[static_cast<std::size_t>(from.first[p])], slot[static_cast<std::size_t>(from.second[p])], springs);
  });
  carried.finish(table, rolls, dormant);
}

}}  // namespace phistep::PHISTEP_ABI
