/// @file
/// Where there may be contacts: the pairs of bodies, in slots sorted by place, that touch or soon may, and walls' bodies.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/particles/bodies/body.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @throws std::invalid_argument where bodies have no radii
void check_bodies(const auto& body, std::ptrdiff_t count) {
  if (body.radius.size() != count)
    throw std::invalid_argument("phistep: contacts need the radii of the particles: set_radius(…)");
}

/// The properties of bodies that contacts use, in slots.
template <class Scalar>
struct ContactBodies {
  std::vector<std::int32_t> particle;  ///< the user's index of a slot's
  std::vector<std::int64_t> id;        ///< and its identity
  std::vector<std::int32_t> slot;      ///< of each particle
  std::vector<Scalar> radius, inverse_radius, inverse_mass;
  std::vector<std::int32_t> type;  ///< or none: all are 0

  [[nodiscard]] std::size_t size() const { return particle.size(); }
  [[nodiscard]] std::int32_t type_of(std::size_t s) const { return type.empty() ? 0 : type[s]; }
  void assign(const auto& body, std::vector<std::int32_t> order) {
    particle = std::move(order);
    const std::size_t n = particle.size();
    id.resize(n), radius.resize(n), inverse_mass.resize(n), type.resize(body.type.size() == 0 ? 0 : n);
    for (std::size_t s = 0; s < n; ++s) {
      const Eigen::Index i = particle[s];
      id[s] = body.id[static_cast<std::size_t>(i)];
      radius[s] = static_cast<Scalar>(body.radius[i]);
      inverse_mass[s] = body.is_still(i) ? Scalar{0} : Scalar{1} / static_cast<Scalar>(body.mass[i]);
      if (!type.empty()) type[s] = body.type_of(i);
    }
    derive();
  }
  /// Whether these are that body's.
  [[nodiscard]] bool are(const auto& body) const {
    if (static_cast<std::size_t>(body.size()) != size() || body.radius.size() != body.size()) return false;
    ContactBodies its;
    its.assign(body, particle);
    return its == *this;
  }
  bool operator==(const ContactBodies&) const = default;
  void archive(auto& ar) {
    ar("particle", particle, "id", id, "radius", radius, "inverse_mass", inverse_mass, "type", type);
    const std::size_t n = size();
    ar.check(id.size() == n && radius.size() == n && inverse_mass.size() == n && (type.empty() || type.size() == n));
    std::vector<std::int32_t> sorted = particle;
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < n; ++i) ar.check(sorted[i] == static_cast<std::int32_t>(i));
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

/// The bodies that walls remember, in the user's order. A place is the number of a wall and that of a body.
struct WallBodies {
  std::vector<std::int64_t> id;

  [[nodiscard]] static std::int64_t place(std::int64_t wall, std::int32_t body) { return wall << 32 | body; }
  [[nodiscard]] static std::int32_t wall_of(std::int64_t place) { return static_cast<std::int32_t>(place >> 32); }
  [[nodiscard]] static std::int32_t body_of(std::int64_t place) { return static_cast<std::int32_t>(place); }
  [[nodiscard]] bool has(std::int64_t place) const {
    return body_of(place) >= 0 && static_cast<std::size_t>(body_of(place)) < id.size();
  }
  /// Of a place: the identity of its body, and its wall.
  [[nodiscard]] std::array<std::int64_t, 2> names(std::int64_t place) const {
    return {id[static_cast<std::size_t>(body_of(place))], wall_of(place)};
  }
  /// Takes springs by these names: see ContactMemory::move_to.
  [[nodiscard]] auto carrier(auto& carried) const {
    return [&carried, index_of = number_by_id(id)](std::int64_t name, std::int64_t wall, const auto& springs) {
      if (const std::int32_t i = index_of(name); i >= 0) carried.add(place(wall, i), springs);
    };
  }
  void archive(auto& ar) { ar("id", id); }
};

/// Slots of pairs, ascending by the pairs' places, and beyond the last some that may be read: a pack more.
struct PairRange {
  const std::int32_t *first = nullptr, *second = nullptr;
  const std::int32_t* place = nullptr;  ///< the pairs' numbers; null: 0, 1, 2 …
  std::size_t count = 0;

  [[nodiscard]] std::int32_t number(std::size_t p) const {
    return place == nullptr ? static_cast<std::int32_t>(p) : place[p];
  }
};

/// The pairs of bodies that touch or soon may, each once, in cache order: pair p joins slots first[p] < second[p], and pairs
/// are sorted by both.
template <class Scalar>
struct ContactPairs {
  static constexpr std::size_t padding = 16;  ///< entries beyond the last pair, readable: a pack more

  ContactBodies<Scalar> bodies;
  std::vector<std::int32_t> first, second;  ///< slots, of each pair and of the padding
  std::vector<std::int32_t> row;            ///< pairs of slot s: row[s] … row[s + 1] − 1
  std::vector<Scalar> built_at;             ///< positions when the pairs were found, 3 a slot [length]
  Scalar skin = 0;                          ///< pairs within R_i + R_j + skin are here [length]
  std::array<double, 3> period{};           ///< as Domain::length
  std::uint64_t number = next_serial();     ///< other pairs, another number

  [[nodiscard]] std::size_t places() const { return first.size() < padding ? 0 : first.size() - padding; }
  [[nodiscard]] PairRange range() const { return {first.data(), second.data(), nullptr, places()}; }
  [[nodiscard]] bool has(std::int32_t place) const { return static_cast<std::size_t>(place) < places(); }
  /// The pair of two slots, or −1.
  [[nodiscard]] std::ptrdiff_t find(std::int32_t a, std::int32_t b) const {
    const auto begin = second.begin() + row[static_cast<std::size_t>(a)],
               end = second.begin() + row[static_cast<std::size_t>(a) + 1];
    const auto at = std::lower_bound(begin, end, b);
    return at != end && *at == b ? at - second.begin() : -1;
  }

  void archive(auto& ar) {
    ar("bodies", bodies, "first", first, "second", second, "row", row, "built_at", built_at, "skin", skin, "period",
       period);
    const std::size_t n = bodies.size(), m = first.size();
    ar.check(second.size() == m && (n == 0 || row.size() == n + 1) && built_at.size() == 3 * n);
    ar.check(n == 0 || (m >= padding && row.front() == 0 && static_cast<std::size_t>(row.back()) == m - padding));
    ar.check(std::is_sorted(row.begin(), row.end()));
    // From a NaN no body would ever have moved.
    ar.check(all_finite(built_at.data(), static_cast<std::ptrdiff_t>(built_at.size())));
    ar.check(std::isfinite(skin) && all_finite(period.data(), 3));
    for (const auto* slots : {&first, &second})
      for (const std::int32_t s : *slots) ar.check(s >= 0 && static_cast<std::size_t>(s) < std::max<std::size_t>(n, 1));
  }
};

/// Where there may be contacts between bodies: `pairs`, and the late pairs of the few bodies, the strays, that have moved far since and had
/// their pairs found alone. The place of a pair is its number, that of a late one a number that no other had.
template <class Scalar>
struct ContactPlaces {
  struct Stray {
    std::int32_t slot;
    std::array<Scalar, 3> at;  ///< where it was when its pairs were found last [length]
  };
  struct Late {
    std::int32_t place, first, second;  ///< slots
  };
  std::shared_ptr<const ContactPairs<Scalar>> pairs;
  std::vector<Stray> strays{};           ///< ascending by slot
  std::vector<Late> late{};              ///< ascending by place, none that is in `pairs`
  std::int32_t next = 0;                 ///< place; 0: pairs->places()
  std::uint64_t number = next_serial();  ///< other strays, another number

  /// f(place, slot, slot) for each pair, ascending.
  void for_each(auto&& f) const {
    for (std::size_t p = 0; p < pairs->places(); ++p)
      f(static_cast<std::int32_t>(p), pairs->first[p], pairs->second[p]);
    for (const Late& pair : late) f(pair.place, pair.first, pair.second);
  }
  /// Null where it is none.
  [[nodiscard]] const Stray* stray(std::int32_t slot) const { return found(strays, &Stray::slot, slot); }
  /// The two slots of a place.
  [[nodiscard]] std::array<std::int32_t, 2> slots(std::int32_t place) const {
    const auto p = static_cast<std::size_t>(place);
    if (p < pairs->places()) return {pairs->first[p], pairs->second[p]};
    const Late& pair = *found(late, &Late::place, place);
    return {pair.first, pair.second};
  }
  [[nodiscard]] bool has(std::int32_t place) const {
    return pairs->has(place) || found(late, &Late::place, place) != nullptr;
  }
  /// The ids of the two bodies of the pair at this place.
  [[nodiscard]] std::array<std::int64_t, 2> names(std::int32_t place) const {
    const auto [a, b] = slots(place);
    return {pairs->bodies.id[static_cast<std::size_t>(a)], pairs->bodies.id[static_cast<std::size_t>(b)]};
  }
  /// Takes springs by these names: see ContactMemory::move_to.
  [[nodiscard]] auto carrier(auto& carried) const {
    auto by_id = number_by_id(pairs->bodies.id,
                              [this](std::size_t k) { return static_cast<std::size_t>(pairs->bodies.slot[k]); });
    return [this, &carried, slot_of = std::move(by_id)](std::int64_t a, std::int64_t b, auto springs) {
      std::int32_t i = slot_of(a), j = slot_of(b);
      if (i < 0 || j < 0) return;
      // Springs belong to the pair in the order of slots. The other way round ξ has the other sign; ψ, n × a turn, has two.
      if (i > j) std::swap(i, j), springs.slip = Scalar{-1} * springs.slip;
      const std::ptrdiff_t place = pairs->find(i, j);
      if (place >= 0) carried.add(static_cast<std::int32_t>(place), springs);
    };
  }
  void archive(auto& ar) {
    constexpr bool reading = std::remove_reference_t<decltype(ar)>::reading;
    auto copy = std::make_shared<ContactPairs<Scalar>>();
    if (!reading && pairs != nullptr) *copy = *pairs;
    copy->archive(ar);
    ar.columns("strays", strays, "slot", &Stray::slot, "at", &Stray::at);
    ar.columns("late_pairs", late, "place", &Late::place, "first", &Late::first, "second", &Late::second);
    ar("next_place", next);
    auto last = static_cast<std::int32_t>(copy->places());
    for (const Late& pair : late) {
      ar.check(pair.place >= std::exchange(last, pair.place + (pair.place < next)) && pair.place < next);
      ar.check(0 <= pair.first && pair.first < pair.second &&
               static_cast<std::size_t>(pair.second) < copy->bodies.size());
    }
    std::int32_t before = -1;
    for (const Stray& stray : strays)
      ar.check(stray.slot > std::exchange(before, stray.slot) && all_finite(stray.at.data(), 3) &&
               static_cast<std::size_t>(stray.slot) < copy->bodies.size());
    if constexpr (reading) pairs = std::move(copy), number = next_serial();
  }

 private:
  template <class T>
  [[nodiscard]] static const T* found(const std::vector<T>& all, std::int32_t T::*key, std::int32_t which) {
    const auto at =
        std::lower_bound(all.begin(), all.end(), which, [key](const T& one, std::int32_t x) { return one.*key < x; });
    return at != all.end() && (*at).*key == which ? &*at : nullptr;
  }
};

/// d ↦ d less the nearest multiple of each axis' period, of differences of two places.
/// @tparam P      numbers or packs
/// @param period  0 where the axis is open
template <class P>
[[nodiscard]] auto nearest_image(const std::array<double, 3>& period) {
  std::array<P, 3> length, inverse;
  for (std::size_t a = 0; a < 3; ++a) {
    length[a] = P(static_cast<typename ScalarIn<P>::type>(period[a]));
    inverse[a] = period[a] > 0 ? P(1) / length[a] : P(0);
  }
  return [length, inverse](const Triple<P>& apart) {
    const auto nearest = [&](P x, std::size_t a) { return x - length[a] * nearest_integer(x * inverse[a]); };
    return Triple<P>{nearest(apart.x, 0), nearest(apart.y, 1), nearest(apart.z, 2)};
  };
}

}}  // namespace phistep::PHISTEP_ABI
