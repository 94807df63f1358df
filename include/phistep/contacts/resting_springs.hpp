/// @file
/// The springs of contacts between bodies that are left out rest beside those that are computed, as they are.
#pragma once

#include <cstddef>

#include "phistep/core/recycled.hpp"
#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Beside those that any memory wants, two that rest: of the step before and of this one.
template <class Table>
using RecycledSprings = Recycled<Table, 6>;

/// Two tables of springs for the same places, none in both, parted anew.
/// @param is_computed  of a place: its springs go to `computed`, the others to `resting`
template <class Table>
void part_springs(const Table& a, const Table& b, auto&& is_computed, Table& computed, Table& resting) {
  const bool rolls = a.rolls();
  const std::size_t all = a.size() + b.size();
  std::size_t goes_on = 0, rests = 0;
  for (Table* to : {&computed, &resting}) to->resize(all, rolls);
  const auto put = [rolls](const Table& from, std::size_t c, Table& to, std::size_t& at) {
    to.place[at] = from.place[c];
    to.slip.set(at, from.slip[c]);
    if (rolls) to.roll.set(at, from.roll[c]);
    ++at;
  };
  for (std::size_t i = 0, j = 0; i < a.size() || j < b.size();) {
    const bool is_first = j == b.size() || (i < a.size() && a.place[i] < b.place[j]);
    const Table& from = is_first ? a : b;
    const std::size_t c = is_first ? i++ : j++;
    if (is_computed(from.place[c])) put(from, c, computed, goes_on);
    else put(from, c, resting, rests);
  }
  computed.resize(goes_on, rolls), resting.resize(rests, rolls);
  computed.close(), resting.close();
}

}  // namespace phistep::inline PHISTEP_ABI
