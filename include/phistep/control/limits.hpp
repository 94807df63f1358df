/// @file
/// What kept the steps of a run from being longer.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "phistep/control/errors/measured.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

enum class LimitedBy : std::uint8_t {
  nobody,
  error,       ///< of the component named
  iterations,  ///< the implicit solve: too many, or it failed
  max_step,
  stop,       ///< a time at which the run was to stop
  not_finite  ///< a longer step met a force or a state that isn't
};

/// One reason, and the number of steps that it shortened.
struct Limit {
  LimitedBy by = LimitedBy::nobody;
  Component where;
  std::int64_t steps = 0;

  void archive(auto& ar) {
    ar("by", by, "block", where.block, "index", where.index, "steps", steps);
    ar.check(by <= LimitedBy::not_finite && can_be_count(steps));
  }
};

/// The most frequent reasons of a run, in bounded memory: the newcomer takes the place of the rarest (A. Metwally,
/// D. Agrawal & A. El Abbadi, ICDT 2005, "space saving"), so that a count may be too large by that of the rarest.
class Limits {
 public:
  void count(LimitedBy by, Component where = {}) {
    ++steps_;
    // Most often it is the one that it was before.
    if (slots_[last_].by != by || slots_[last_].where != where) find(by, where);
    ++slots_[last_].steps;
  }
  /// The most frequent reason.
  [[nodiscard]] Limit most() const {
    return *std::max_element(slots_.begin(), slots_.end(), [](auto& a, auto& b) { return a.steps < b.steps; });
  }
  [[nodiscard]] std::int64_t steps() const { return steps_; }

  /// "  dt limited by       component 3 of block 0, in 71 % of the steps"
  template <class OStream>
    requires requires(OStream& out) { out << "" << std::int64_t{}; }
  friend OStream& operator<<(OStream& out, const Limits& limits) {
    const Limit most = limits.most();
    if (most.by == LimitedBy::nobody || limits.steps_ == 0) return out;
    out << "  dt limited by       ";
    switch (most.by) {
      case LimitedBy::error:
        out << "the error of component " << most.where.index << " of block " << most.where.block;
        break;
      case LimitedBy::iterations:
        out << "the iterations of the implicit solve";
        break;
      case LimitedBy::max_step:
        out << "max_step";
        break;
      case LimitedBy::not_finite:
        out << "a force or a state that is not finite";
        break;
      default:
        out << "the times to stop at";
    }
    out << ", in " << 100 * most.steps / limits.steps_ << " % of the steps\n";
    return out;
  }

  void archive(auto& ar) {
    ar("reasons", slots_, "steps", steps_);
    ar.check(can_be_count(steps_));
  }

 private:
  [[gnu::noinline]] void find(LimitedBy by, Component where) {
    auto slot =
        std::find_if(slots_.begin(), slots_.end(), [&](const Limit& x) { return x.by == by && x.where == where; });
    if (slot == slots_.end()) {
      slot = std::min_element(slots_.begin(), slots_.end(), [](auto& a, auto& b) { return a.steps < b.steps; });
      slot->by = by;
      slot->where = where;
    }
    last_ = static_cast<std::size_t>(slot - slots_.begin());
  }

  std::array<Limit, 8> slots_{};
  std::size_t last_ = 0;
  std::int64_t steps_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
