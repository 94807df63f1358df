/// @file
/// What kept the steps of a run from being longer.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>

#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/errors/measured.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// An option that can't work.
struct Refused {
  const char* option = nullptr;  ///< null: there is none
  std::optional<double> is{};    ///< its value
  double least = 0;              ///< the least that works, where that is known
};

enum class LimitedBy : std::uint8_t {
  nothing,
  error,       ///< of the component named
  iterations,  ///< the implicit solve: too many, or it failed
  max_step,
  stop,       ///< a time at which the run was to stop
  not_finite  ///< a longer step met a force or a state that isn't
};

/// One reason, and the number of steps that it shortened.
struct Limit {
  LimitedBy by = LimitedBy::nothing;
  Component where;  ///< of an error: a component that ruled, that of more than half of the steps if there is one
  std::int64_t steps = 0;
};

/// Of the components that some steps named, that of more than half of them, if there is one (the majority vote of R. S. Boyer &
/// J S. Moore, 1981).
class MostNamed {
 public:
  void name(const Component& one) {
    if (votes_ == 0) where_ = one;
    votes_ += one == where_ ? 1 : -1;
    ++steps_;
  }
  [[nodiscard]] const Component& where() const { return where_; }
  [[nodiscard]] std::int64_t steps() const { return steps_; }
  void archive(auto& ar) {
    ar("block", where_.block, "index", where_.index, "votes", votes_, "named", steps_);
    ar.check(can_be_count(steps_) && 0 <= votes_ && votes_ <= steps_);
  }

 private:
  Component where_;
  std::int64_t votes_ = 0, steps_ = 0;  // for where_, less those against; of all
};

/// Counts the steps by reason, and what a run without atol has seen of its components.
class Limits {
 public:
  void count(LimitedBy by, Component where = {}) {
    ++steps_[static_cast<std::size_t>(by)];
    if (by == LimitedBy::error) worst_.name(where);
  }
  /// The most frequent reason.
  [[nodiscard]] Limit most() const {
    const auto most = std::max_element(steps_.begin(), steps_.end());
    if (*most == 0) return {};
    const auto by = static_cast<LimitedBy>(most - steps_.begin());
    return {by, by == LimitedBy::error ? worst_.where() : Component{}, *most};
  }
  [[nodiscard]] std::int64_t steps() const { return std::accumulate(steps_.begin(), steps_.end(), std::int64_t{0}); }

  /// The component that ruled by its error.
  [[nodiscard]] const Component& worst() const { return worst_.where(); }
  /// Scales without atol: components of which less was asked than rtol of what they are; that grew 10³ times in one step.
  MostNamed below, leapt;
  bool has_own_scales = false;

  /// "  dt limited by       the error, e.g. of component 3 of block 0, in 71 % of the steps"
  template <class OStream>
    requires requires(OStream& out) { out << "" << std::int64_t{}; }
  friend OStream& operator<<(OStream& out, const Limits& limits) {
    const Limit most = limits.most();
    if (most.by == LimitedBy::nothing) return out;
    static constexpr const char* names[]{
        "nothing",  "the error, e.g. of component ", "the iterations of the implicit solve",
        "max_step", "the times to stop at",          "a force or a state that is not finite"};
    out << "  dt limited by       " << names[static_cast<std::size_t>(most.by)];
    if (most.by == LimitedBy::error) out << most.where.index << " of block " << most.where.block;
    out << ", in " << 100 * most.steps / limits.steps() << " % of the steps\n";
    if (!limits.has_own_scales) return out;
    out << "  atol                none given";
    if (limits.below.steps() > 0)
      out << ": component " << limits.below.where().index << " of block " << limits.below.where().block
          << ", or another, had fewer digits than rtol in " << 100 * limits.below.steps() / limits.steps()
          << " % of the steps";
    out << '\n';
    return out;
  }

  void archive(auto& ar) {
    ar("steps", steps_, "worst", worst_, "below", below, "leapt", leapt, "own_scales", has_own_scales);
    for (const std::int64_t steps : steps_) ar.check(can_be_count(steps));
  }

 private:
  std::array<std::int64_t, static_cast<std::size_t>(LimitedBy::not_finite) + 1> steps_{};
  MostNamed worst_;
};

}}  // namespace phistep::PHISTEP_ABI
