/// @file
/// What contacts remember: where bodies may touch, and how far the springs of those that do are stretched.
///
/// A spring's length ξ is known at a time t_c. An evaluation at (t_e, Y) starts from it and never changes it, whatever
/// Newton asks for and however often a step is rejected: it leaves its own ξ(t_e) beside. Where a step was made of one
/// evaluation, that becomes the memory when the step is accepted, and t_c = t_e; otherwise ξ is computed once more, for the
/// accepted state, and t_c is the end of the step.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/machine/scratch.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/contacts/spring_table.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// The springs of contacts between bodies outside the active set: they are kept unchanged, apart from those that are computed.
//
// When bodies join or leave the active set, few springs move from one side to the other. Most springs at rest therefore stay in
// a table that never changes and that several histories share. Bits mark the springs removed from it since; a second, small
// table holds the springs added since. When that has grown, both are merged into a new table.

template <class Table>
struct RestingSprings {
  std::shared_ptr<const Table> base;
  std::vector<std::uint64_t> taken;  ///< a bit for each contact of the base: its spring was removed
  Table late;                        ///< the springs added since

  [[nodiscard]] bool is_taken(std::size_t c) const { return (taken[c / 64] >> (c % 64) & 1) != 0; }
  void take(std::size_t c) { taken[c / 64] |= std::uint64_t{1} << (c % 64); }
};

/// Memory for reuse: tables, old and new bases among them, and the springs at rest that refer to them.
template <class Table>
struct RecycledSprings : Recycled<Table, 6> {
  Recycled<RestingSprings<Table>> resting;
};

/// Some contacts of a table of springs, ascending by place.
template <class Table>
struct SomeSprings {
  const Table* table = nullptr;
  std::vector<std::size_t> some{};  ///< which; unused where `all`
  bool all = true;

  [[nodiscard]] std::size_t size() const { return table == nullptr ? 0 : all ? table->size() : some.size(); }
  [[nodiscard]] std::size_t operator[](std::size_t k) const { return all ? k : some[k]; }
};

/// Sorts springs, no two of one place, into the tables a and b, each ascending by place.
/// @param goes_to_a  of a place
template <class Table, std::size_t n>
void sort_springs(const std::array<SomeSprings<Table>, n>& from, bool rolls, auto&& goes_to_a, Table& a, Table& b) {
  std::size_t most = 0, in_a = 0, in_b = 0;
  for (const auto& some : from) most += some.size();
  for (Table* to : {&a, &b}) to->resize(most, rolls);
  const auto put = [rolls](const Table& table, std::size_t c, Table& to, std::size_t& at) {
    to.place[at] = table.place[c];
    to.slip.set(at, table.slip[c]);
    if (rolls) to.roll.set(at, table.roll[c]);
    ++at;
  };
  std::array<std::size_t, n> at{};
  for (;;) {
    const SomeSprings<Table>* next = nullptr;
    std::size_t k = 0;
    for (std::size_t f = 0; f < n; ++f) {
      if (at[f] == from[f].size()) continue;
      const std::size_t c = from[f][at[f]];
      if (next == nullptr || from[f].table->place[c] < next->table->place[(*next)[at[k]]]) next = &from[f], k = f;
    }
    if (next == nullptr) break;
    const std::size_t c = (*next)[at[k]++];
    if (goes_to_a(next->table->place[c])) put(*next->table, c, a, in_a);
    else put(*next->table, c, b, in_b);
  }
  a.resize(in_a, rolls), b.resize(in_b, rolls);
  a.close(), b.close();
}

/// Divides all springs, those of `springs` and those at rest (null: none), between `computed` and a new base.
/// @param is_computed  (place) → bool: its springs go to `computed`, the others to the base
template <class Table>
[[nodiscard]] std::shared_ptr<const RestingSprings<Table>> part_all_springs(const Table& springs,
                                                                            const RestingSprings<Table>* resting,
                                                                            auto&& is_computed, Table& computed,
                                                                            RecycledSprings<Table>& tables) {
  std::array<SomeSprings<Table>, 3> from{SomeSprings<Table>{&springs}};
  if (resting != nullptr) {
    from[1] = {resting->base.get(), {}, false}, from[2] = {&resting->late};
    for (std::size_t c = 0; c < resting->base->size(); ++c)
      if (!resting->is_taken(c)) from[1].some.push_back(c);
  }
  auto base = tables.take();
  auto out = tables.resting.take();
  sort_springs(from, springs.rolls(), is_computed, computed, *base);
  out->taken.assign(base->size() / 64 + 1, 0);
  out->late.resize(0, springs.rolls());
  out->late.close();
  out->base = std::move(base);
  return out;
}

/// The same where few springs change sides: the base remains.
/// @param joined  the places, ascending, that are computed from now on
template <class Table>
[[nodiscard]] std::shared_ptr<const RestingSprings<Table>> part_some_springs(
    const Table& springs, const RestingSprings<Table>& resting, const std::vector<typename Table::Place>& joined,
    auto&& is_computed, Table& computed, RecycledSprings<Table>& tables) {
  auto out = tables.resting.take();
  out->taken = resting.taken;
  SomeSprings<Table> back{resting.base.get(), {}, false};
  const auto& places = resting.base->place;
  auto at = places.begin();
  for (const auto place : joined) {
    at = std::lower_bound(at, places.end(), place);
    if (at == places.end()) break;
    const auto c = static_cast<std::size_t>(at - places.begin());
    if (*at != place || resting.is_taken(c)) continue;
    back.some.push_back(c);
    out->take(c);
  }
  sort_springs(std::array{SomeSprings<Table>{&springs}, SomeSprings<Table>{&resting.late}, std::move(back)},
               springs.rolls(), is_computed, computed, out->late);
  out->base = resting.base;
  return out;
}

/// The history of a force with contacts, as a value: copies share what they point to, which is never changed.
/// @tparam Places  enumerates where there may be contacts
/// @tparam Place   the number of one
template <class Scalar, class Places, class Place = std::int32_t>
struct ContactMemory {
  using Table = SpringTable<Scalar, Place>;

  // An evaluation may find that the places must be enumerated anew, and leaves its springs: hence mutable. What a step
  // commits or drops is always the trial's.
  mutable std::shared_ptr<const Places> places;
  mutable std::shared_ptr<const Table> springs;                   ///< ξ(t_c), for `places`
  mutable std::shared_ptr<const Table> last;                      ///< ξ(t_e) of the last evaluation, likewise
  mutable std::shared_ptr<const DormantSprings<Scalar>> dormant;  ///< of none, where there is nothing
  mutable std::shared_ptr<const RestingSprings<Table>> resting;   ///< of contacts left out for now, or none
  mutable std::uint64_t active = 0;      ///< number of the set that `springs` are those of; 0: all
  mutable std::uint64_t body = 0;        ///< serial number of what `places` were enumerated for
  mutable Scalar last_time = 0;          ///< t_e
  mutable std::int64_t evaluations = 0;  ///< since the step began
  Scalar time = 0;                       ///< where the step began, or the last one ended
  Scalar step = 0;                       ///< Δt
  Scalar lag = 0;                        ///< time − t_c

  void begin(Scalar t, Scalar dt) {
    time = t;
    step = dt;
    evaluations = 0;
    last.reset();
  }
  /// Time since the springs were known. As a sum of lags rather than a difference of times: exactly Δt where it should be.
  [[nodiscard]] Scalar elapsed(Scalar t) const { return lag + (t - time); }
  void remember(Scalar t, std::shared_ptr<const Table> found) const {
    last = std::move(found);
    last_time = t;
    ++evaluations;
  }
  /// At the end of an accepted step. @param springs_now  computes them for the accepted state; called where there
  /// were several evaluations
  void commit(auto&& springs_now) {
    if (evaluations > 1) {
      springs = springs_now();
      lag = 0;
    } else if (evaluations == 1) {
      springs = std::move(last);
      lag = step - (last_time - time);
    } else {
      lag += step;
    }
    time += step;
    last.reset();
  }
  /// From now on the springs of an active set's contacts are computed, the others rest.
  /// @param number       of the set; 0: all are computed
  /// @param is_computed  of a place; not asked where all are
  /// @param tables       makes room for them
  /// @param before       number of a set for which `joined` holds; 0: of none
  /// @param joined       places, ascending, that are computed now and were not for that set
  void part(std::uint64_t number, auto&& is_computed, RecycledSprings<Table>& tables, std::uint64_t before = 0,
            const std::vector<Place>& joined = {}) const {
    if (number == active || springs == nullptr) return;
    const auto goes_on = [&](Place place) { return number == 0 || is_computed(place); };
    auto computed = tables.take();
    const bool is_small = resting && resting->late.size() <= 256 + resting->base->size() / 8;
    auto rest = number != 0 && before != 0 && before == active && is_small
                    ? part_some_springs(*springs, *resting, joined, goes_on, *computed, tables)
                    : part_all_springs(*springs, resting.get(), goes_on, *computed, tables);
    springs = std::move(computed);
    resting = number == 0 ? nullptr : std::move(rest);
    active = number;
  }
  /// All of them are computed again.
  void join(RecycledSprings<Table>& tables) const {
    part(
        0, [](auto) { return true; }, tables);
  }
  /// The places serve bodies that were copied or came with a checkpoint, too; the springs may be another force's.
  void adopt(std::uint64_t serial, bool rolls, RecycledSprings<Table>& tables) const {
    body = serial;
    if (springs->rolls() == rolls) return;
    join(tables);
    auto with_or_without = std::make_shared<Table>(*springs);
    with_or_without->resize(springs->size(), rolls);
    with_or_without->close();
    springs = std::move(with_or_without);
  }

  void archive(auto& ar) {
    Places its_places = places ? *places : Places{};
    ContactMemory whole = *this;
    RecycledSprings<Table> tables;
    whole.join(tables);
    Table its_springs = springs ? *whole.springs : Table{};
    DormantSprings<Scalar> its_dormant = dormant ? *dormant : DormantSprings<Scalar>{};
    ar("places", its_places, "springs", its_springs, "dormant", its_dormant, "time", time, "step", step, "lag", lag);
    ar.check(std::isfinite(time) && std::isfinite(step) && std::isfinite(lag));
    if constexpr (std::remove_reference_t<decltype(ar)>::reading) {
      for (const auto place : its_springs.place) ar.check(its_places.has(place));
      last.reset();
      resting.reset();
      active = body = 0;
      evaluations = 0;
      // The next evaluation compares them with its particles.
      places = std::make_shared<const Places>(std::move(its_places));
      springs = std::make_shared<const Table>(std::move(its_springs));
      dormant = std::make_shared<const DormantSprings<Scalar>>(std::move(its_dormant));
    }
  }
};

}}  // namespace phistep::PHISTEP_ABI
