/// @file
/// Rows of an extrapolated step, several at a time. Within a row each substep waits for the one before, for the latency of
/// a force call and of a solve; rows don't wait for each other. So a few of them advance side by side, which at 2 and 3
/// unknowns takes a half and a third of the time. Each row ends in the bits that it would have had alone.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "phistep/control/trace.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A step's data, and its trace where it has one.
template <class Kernel>
struct RowData : Kernel::Data {
  Trace<typename Kernel::Plain>* trace;
};

/// A row on its way. @tparam Fixed  what all its substeps share  @tparam Moving  what each one changes
template <class Fixed, class Moving>
struct Lane {
  Fixed fixed;
  Moving moving;
  int row = 0, left = 0, done = 0;  ///< its number, substeps to do, substeps done
};

/// A base method offers
///
///     static constexpr int lanes, alone;                      how many at once; rows 1 … alone come first, one by one
///     static constexpr bool on_stack;                         Moving fits into registers
///     Outcome start(lane, row, substeps, theta)               sets the lane up; may do the first substeps
///     substep(fixed, done, moving)                            one more
///     Outcome finish(lane, end)                               end = T_{row,1}
///
/// @param ends   ends[j] = T_{j,1} for from ≤ j ≤ to
/// @param theta  above 1: the rows were given up
template <class LaneMethod, class Lanes>
class RowLanes {
 public:
  RowLanes(LaneMethod& method, Lanes& lane) : method_{method}, lane_{lane} {}

  [[nodiscard]] Outcome run(auto& ends, const auto& substeps, int from, int to, double& theta) {
    const auto start = [&](auto& lane, int row) {
      lane.row = row;
      lane.left = substeps[at(row)];
      lane.done = 0;
      return method_.start(lane, row, substeps[at(row)], theta);
    };
    for (; from <= LaneMethod::alone && from <= to; ++from) {
      if (const Outcome outcome = start(lane_[0], from); outcome != Outcome::success) return outcome;
      if (theta > 1) return Outcome::success;
      advance<1>(lane_[0].left);
      if (const Outcome outcome = method_.finish(lane_[0], ends[at(from)]); outcome != Outcome::success) return outcome;
    }
    // The longest rows first: the lanes then end together.
    int next = to, active = 0;
    for (; active < lanes && next >= from; ++active, --next)
      if (const Outcome outcome = start(lane_[at(active)], next); outcome != Outcome::success) return outcome;
    while (active > 0) {
      int least = lane_[0].left;
      for (int l = 1; l < active; ++l) least = std::min(least, lane_[at(l)].left);
      if (active == 1) advance<1>(least);
      if constexpr (lanes >= 2)
        if (active == 2) advance<2>(least);
      if constexpr (lanes >= 3)
        if (active == 3) advance<3>(least);
      for (int l = active - 1; l >= 0; --l) {
        auto& lane = lane_[at(l)];
        if (lane.left > 0) continue;
        if (const Outcome outcome = method_.finish(lane, ends[at(lane.row)]); outcome != Outcome::success)
          return outcome;
        if (next >= from) {
          if (const Outcome outcome = start(lane, next); outcome != Outcome::success) return outcome;
          --next;
        } else {
          --active;
          if constexpr (lanes > 1)
            if (l != active) lane = lane_[at(active)];
        }
      }
    }
    return Outcome::success;
  }

 private:
  static constexpr int lanes = LaneMethod::lanes;
  static_assert(1 <= lanes && lanes <= 3);
  static constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

  // Flat: one force or product that isn't inlined costs as much as the substep.
  template <int count>
  [[gnu::flatten, gnu::noinline]] void advance(int substeps) {
    if constexpr (LaneMethod::on_stack) {
      [&]<std::size_t... l>(std::index_sequence<l...>) {
        // In variables of their own: numbers stored one by one can't be loaded as a packet at once.
        std::array moving{lane_[l].moving...};
        for (int i = 0; i < substeps; ++i)
          (method_.substep(std::as_const(lane_[l].fixed), lane_[l].done + i, moving[l]), ...);
        ((lane_[l].moving = moving[l], lane_[l].done += substeps, lane_[l].left -= substeps), ...);
      }
      (std::make_index_sequence<count>{});
    } else {
      auto& lane = lane_[0];
      for (; lane.left > 0; ++lane.done, --lane.left)
        method_.substep(std::as_const(lane.fixed), lane.done, lane.moving);
    }
  }

  LaneMethod& method_;
  Lanes& lane_;
};

}}  // namespace phistep::PHISTEP_ABI
