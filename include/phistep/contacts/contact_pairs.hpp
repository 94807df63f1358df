/// @file
/// The pairs of bodies that touch or soon may, each once, in cache order.
///
/// Particles stand in slots sorted by place; pair p joins slots first[p] < second[p], and pairs are sorted by both. A body
/// held still has no pair with another one.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/contacts/contact_memory.hpp"
#include "phistep/core/version.hpp"
#include "phistep/simd/update.hpp"

namespace phistep::inline PHISTEP_ABI {

/// @throws std::invalid_argument where contacts can't be computed for these bodies
template <class Body>
void check_bodies(const Body& body, std::ptrdiff_t count) {
  if (body.radius.size() != count)
    throw std::invalid_argument("phistep: contacts need the radii of the particles: set_radius(…)");
  for (Eigen::Index i = 0; i < body.radius.size(); ++i)
    if (!(body.radius[i] > 0) || !std::isfinite(body.radius[i]) || !(body.mass[i] > 0) || !std::isfinite(body.mass[i]))
      throw std::invalid_argument("phistep: the radius and mass of particle " + std::to_string(i) +
                                  " must be finite and > 0");
}

/// The properties of bodies that contacts use, in slots.
template <class Scalar>
struct ContactBodies {
  std::vector<std::int32_t> particle;  ///< the user's index of a slot's
  std::vector<std::int64_t> id;        ///< and its identity
  std::vector<std::int32_t> slot;      ///< of each particle
  std::vector<Scalar> radius, inverse_radius, inverse_mass;
  std::vector<std::int32_t> type;

  [[nodiscard]] std::size_t size() const { return particle.size(); }
  void assign(const auto& body, std::vector<std::int32_t> order) {
    particle = std::move(order);
    const std::size_t n = particle.size();
    id.resize(n), radius.resize(n), inverse_mass.resize(n), type.resize(n);
    for (std::size_t s = 0; s < n; ++s) {
      const Eigen::Index i = particle[s];
      id[s] = body.id[static_cast<std::size_t>(i)];
      radius[s] = static_cast<Scalar>(body.radius[i]);
      inverse_mass[s] = body.is_still(i) ? Scalar{0} : Scalar{1} / static_cast<Scalar>(body.mass[i]);
      type[s] = body.type_of(i);
    }
    derive();
  }
  /// Whether these are that body's.
  [[nodiscard]] bool are(const auto& body) const {
    if (static_cast<std::size_t>(body.size()) != size() || body.radius.size() != body.size()) return false;
    for (std::size_t s = 0; s < size(); ++s) {
      const Eigen::Index i = particle[s];
      const Scalar inverse = body.is_still(i) ? Scalar{0} : Scalar{1} / static_cast<Scalar>(body.mass[i]);
      if (id[s] != body.id[static_cast<std::size_t>(i)] || radius[s] != static_cast<Scalar>(body.radius[i]) ||
          inverse_mass[s] != inverse || type[s] != body.type_of(i))
        return false;
    }
    return true;
  }
  void archive(auto& ar) {
    ar("particle", particle, "id", id, "radius", radius, "inverse_mass", inverse_mass, "type", type);
    const std::size_t n = size();
    ar.check(id.size() == n && radius.size() == n && inverse_mass.size() == n && type.size() == n);
    std::vector<std::uint8_t> seen(n, 0);
    for (const std::int32_t i : particle) {
      ar.check(i >= 0 && static_cast<std::size_t>(i) < n && seen[static_cast<std::size_t>(i)] == 0);
      seen[static_cast<std::size_t>(i)] = 1;
    }
    derive();
  }

 private:
  void derive() {
    slot.resize(size());
    inverse_radius.resize(size());
    for (std::size_t s = 0; s < size(); ++s) {
      slot[static_cast<std::size_t>(particle[s])] = static_cast<std::int32_t>(s);
      inverse_radius[s] = Scalar{1} / radius[s];
    }
  }
};

/// Where the body of an identity stands.
class SlotsById {
 public:
  explicit SlotsById(const std::vector<std::int64_t>& ids) : sorted_(ids.size()) {
    for (std::size_t s = 0; s < ids.size(); ++s) sorted_[s] = {ids[s], static_cast<std::int32_t>(s)};
    std::sort(sorted_.begin(), sorted_.end());
  }
  /// −1: it isn't there.
  [[nodiscard]] std::int32_t operator()(std::int64_t id) const {
    const auto at = std::lower_bound(sorted_.begin(), sorted_.end(), std::pair{id, std::int32_t{0}});
    return at != sorted_.end() && at->first == id ? at->second : -1;
  }

 private:
  std::vector<std::pair<std::int64_t, std::int32_t>> sorted_;
};

template <class Scalar>
struct ContactPairs {
  static constexpr std::size_t padding = 16;  ///< entries beyond the last pair, readable: a pack more

  ContactBodies<Scalar> bodies;
  std::vector<std::int32_t> first, second;  ///< slots, of each pair and of the padding
  std::vector<std::int32_t> row;            ///< pairs of slot s: row[s] … row[s + 1] − 1
  std::vector<Scalar> built_at;             ///< positions when the pairs were found, 4 a slot: x, y, z, 0 [length]
  Scalar skin = 0;                          ///< pairs within R_i + R_j + skin are here [length]
  Scalar period[3] = {0, 0, 0};             ///< 0: the axis is open [length]

  [[nodiscard]] std::size_t places() const { return first.size() < padding ? 0 : first.size() - padding; }
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
    ar.check(second.size() == m && (n == 0 || row.size() == n + 1) && built_at.size() == 4 * n);
    ar.check(n == 0 || (m >= padding && row.front() == 0 && static_cast<std::size_t>(row.back()) == m - padding));
    ar.check(std::is_sorted(row.begin(), row.end()));
    // From where a position isn't a number, nothing would ever have moved.
    ar.check(all_finite(built_at.data(), static_cast<std::ptrdiff_t>(built_at.size())));
    ar.check(std::isfinite(skin) && all_finite(period, 3));
    for (const auto* slots : {&first, &second})
      for (const std::int32_t s : *slots) ar.check(s >= 0 && static_cast<std::size_t>(s) < std::max<std::size_t>(n, 1));
  }
};

/// x less the nearest multiple of the period; an axis without one has 0 for both.
template <class P>
[[nodiscard]] P nearest_image(P x, P period, P inverse) {
  return x - period * nearest_integer(x * inverse);
}

/// Springs of the same contacts, found by the bodies' identities, in the places of other pairs. New ones begin unstretched.
/// Those of pairs that are listed no more because both bodies are held still lie dormant from then on, until one moves.
/// @param rolls        whether there are springs of rolling
/// @param same_bodies  the users' indices still mean the same bodies
/// @param dormant      those known so far, or none; replaced where they change
template <class Scalar>
void carry_springs(const ContactPairs<Scalar>& from, const SpringTable<Scalar>& old, const ContactPairs<Scalar>& to,
                   SpringTable<Scalar>& springs, bool rolls, bool same_bodies,
                   std::shared_ptr<const DormantSprings<Scalar>>& dormant) {
  using Three = std::array<Scalar, 3>;
  struct Kept {
    std::int32_t place;
    Three slip, roll;
  };
  std::vector<Kept> kept;
  kept.reserve(old.size());
  DormantSprings<Scalar> asleep;
  const auto is_still = [&to](std::int32_t slot) {
    return !(to.bodies.inverse_mass[static_cast<std::size_t>(slot)] > Scalar{0});
  };
  // Springs belong to the pair in the order of slots.
  const auto carry = [&](std::int32_t i, std::int32_t j, Three slip, Three roll) {
    if (i < 0 || j < 0) return;
    const std::ptrdiff_t place = to.find(std::min(i, j), std::max(i, j));
    if (place < 0 && !(is_still(i) && is_still(j))) return;
    if (i > j)
      for (std::size_t a = 0; a < 3; ++a) slip[a] = -slip[a], roll[a] = -roll[a];
    if (place >= 0) {
      kept.push_back({static_cast<std::int32_t>(place), slip, roll});
    } else {
      const auto a = static_cast<std::size_t>(std::min(i, j)), b = static_cast<std::size_t>(std::max(i, j));
      asleep.contacts.push_back({to.bodies.id[a], to.bodies.id[b], slip, roll});
    }
  };

  std::vector<std::int32_t> slot(from.bodies.size(), -1);  // where a slot's body stands now
  const bool has_dormant = dormant && !dormant->contacts.empty();
  if (!same_bodies || has_dormant) {
    const SlotsById by_id{to.bodies.id};
    for (std::size_t s = 0; s < slot.size(); ++s) slot[s] = by_id(from.bodies.id[s]);
    if (has_dormant)
      for (const auto& one : dormant->contacts) carry(by_id(one.a), by_id(one.b), one.slip, one.roll);
  } else {
    for (std::size_t s = 0; s < slot.size(); ++s)
      slot[s] = to.bodies.slot[static_cast<std::size_t>(from.bodies.particle[s])];
  }
  for (std::size_t c = 0; c < old.size(); ++c) {
    const auto p = static_cast<std::size_t>(old.place[c]);
    Three slip{}, roll{};
    for (std::size_t a = 0; a < 3; ++a) {
      slip[a] = old.slip.x[a][c];
      if (old.rolls()) roll[a] = old.roll.x[a][c];
    }
    carry(slot[static_cast<std::size_t>(from.first[p])], slot[static_cast<std::size_t>(from.second[p])], slip, roll);
  }
  std::sort(kept.begin(), kept.end(), [](const Kept& a, const Kept& b) { return a.place < b.place; });
  springs.resize(kept.size(), rolls);
  for (std::size_t c = 0; c < kept.size(); ++c) {
    springs.place[c] = kept[c].place;
    for (std::size_t a = 0; a < 3; ++a) {
      springs.slip.x[a][c] = kept[c].slip[a];
      if (rolls) springs.roll.x[a][c] = kept[c].roll[a];
    }
  }
  springs.close();
  if (has_dormant || !asleep.contacts.empty())
    dormant = std::make_shared<const DormantSprings<Scalar>>(std::move(asleep));
}

}  // namespace phistep::inline PHISTEP_ABI
