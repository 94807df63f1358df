/// @file
/// The springs of contacts between bodies outside the active set: they are kept unchanged, apart from those that are computed.
///
/// When bodies join or leave the active set, few springs move from one side to the other. Most springs at rest therefore stay in
/// a table that never changes and that several histories share. Bits mark the springs removed from it since; a second, small
/// table holds the springs added since. When that has grown, both are merged into a new table.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "phistep/base/machine/scratch.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

}}  // namespace phistep::PHISTEP_ABI
