/// @file
/// The pace of runs with a fixed Δt.
#pragma once

#include <cstdint>
#include <optional>

#include "phistep/control/fixed_step.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Steps of one length, on the grid t₀ + nΔt, whatever stops and events lie in between.
template <class Scalar>
class GridPace {
 public:
  explicit GridPace(const FixedStep& control) : control_{control} {}
  [[nodiscard]] Outcome begin(TimeSpan<Scalar> span) {
    grid_.emplace(span, control_);
    done_ = 0;
    node_ = span.t0;
    return grid_->outcome();
  }
  /// Where the step from t ends if nothing comes between.
  [[nodiscard]] Scalar end() const { return grid_->time(done_ + 1); }
  /// Its length: the nominal one from node to node, whose times differ by that only up to rounding.
  [[nodiscard]] Scalar length(Scalar t) const {
    return t == node_ ? grid_->step(done_) : -grid_->from_node(done_ + 1, t);
  }
  /// The length from t to a stop before the next node.
  [[nodiscard]] Scalar length(Scalar t, Scalar stop) const {
    return t == node_ ? grid_->from_node(done_, stop) : stop - t;
  }
  [[nodiscard]] bool at_end() const { return done_ >= grid_->steps(); }
  /// The next node is reached, at t: its own time or one that is the same up to rounding.
  void reached(Scalar t) {
    ++done_;
    node_ = t;
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

}  // namespace phistep::inline PHISTEP_ABI
