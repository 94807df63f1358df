/// @file
/// The pace of runs with a fixed Δt.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/control/fixed_step.hpp"
#include "phistep/run/control/limits.hpp"
#include "phistep/run/control/run_clock.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Steps of one length, on the grid t₀ + nΔt, whatever stops and events lie in between.
template <class Scalar>
class GridPace {
 public:
  static constexpr bool sees_error = false, varies = false;

  explicit GridPace(const FixedStep& control) : control_{control} {}
  [[nodiscard]] Outcome begin(TimeSpan<Scalar> span) {
    grid_.emplace(span, control_);
    done_ = 0;
    node_ = span.t0;
    return grid_->outcome();
  }
  /// After an outcome that refuses it.
  [[nodiscard]] Refused refused() const { return {"dt", control_.dt}; }
  /// Whether the clock can tell an event from the next step's: Δt is 64 of its ticks at least.
  [[nodiscard]] bool suits_events(const RunClock<Scalar>& clock) const {
    const auto [t0, t1] = clock.span();
    return t0 == t1 ||
           !(std::abs(control_.dt) < 64 * static_cast<double>(spacing(std::max(std::abs(t0), std::abs(t1)))));
  }
  /// To the next node, or to a stop before it.
  [[nodiscard]] Landing<Scalar> plan(const RunClock<Scalar>& clock, std::optional<Scalar> stop) const {
    const Scalar node = grid_->time(done_ + 1), t = clock.t();
    // A stop that rounding alone keeps from a node is that node, unless that is the end.
    const Scalar beyond = stop ? clock.sign() * (node - *stop) : Scalar{-1};
    const Scalar same = node == clock.span().t1 ? Scalar{0} : clock.rounding(node);
    if (beyond > same) return {*stop, length(t, *stop), true, true};
    // From node to node Δt is the nominal one: their times differ by that only up to rounding.
    const Scalar whole = t == node_ ? grid_->step(done_) : -grid_->from_node(done_ + 1, t);
    return {stop && -beyond <= same ? *stop : node, whole, true, false, true};
  }
  /// The steps of equal length ahead; none unless the run stands exactly at a node of the grid.
  [[nodiscard]] GridSteps<Scalar> ahead(const RunClock<Scalar>& clock) const {
    const bool at_node = clock.t() == grid_->time(done_);
    return {clock.span().t0, grid_->step(0), done_,
            at_node ? std::max<std::int64_t>(grid_->steps() - 1 - done_, 0) : 0};
  }
  /// Where the first n of them end.
  [[nodiscard]] Landing<Scalar> after(std::int64_t n) const {
    return {grid_->time(done_ + n), grid_->step(done_), true, false, true, n};
  }
  /// The length from t to a stop before the next node.
  [[nodiscard]] Scalar length(Scalar t, Scalar stop) const {
    return t == node_ ? grid_->from_node(done_, stop) : stop - t;
  }
  [[nodiscard]] bool is_at_end(const RunClock<Scalar>&) const { return done_ >= grid_->steps(); }
  [[nodiscard]] static bool may_try() { return true; }
  /// The step has become the state. A node is reached at its own time or at one that is the same up to rounding.
  void accepted(const Landing<Scalar>& landed) {
    if (!landed.is_node) return;
    done_ += landed.steps;
    node_ = landed.end;
  }
  void archive(auto& ar) {
    ar("done", done_, "node", node_);
    ar.check(0 <= done_ && std::isfinite(node_) && (!grid_ || done_ <= grid_->steps()));
  }

 private:
  FixedStep control_;
  std::optional<TimeGrid<Scalar>> grid_;
  std::int64_t done_ = 0;
  Scalar node_{0};  // [time] where the last node was reached
};

}}  // namespace phistep::PHISTEP_ABI
