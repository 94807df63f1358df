/// @file
/// What rounding took from the state in one step, kept for the next: compensated sums (W. Kahan, Comm. ACM 8 (1965) 40;
/// E. Hairer, C. Lubich & G. Wanner, Geometric Numerical Integration, VIII.5), one a step and component,
///
///     δ = Δy + lost,   y⁺ = y + δ,   lost⁺ = δ − (y⁺ − y)
///
/// It belongs to the state that the last step left, bit for bit: any other starts with none.
#pragma once

#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @tparam kept  false: nothing is kept, and nothing costs
template <State S, bool kept>
class CarriedRounding {
 public:
  using Plain = PlainState<S>;
  static constexpr bool is_kept = kept;

  void resize(const Plain& y) {
    for (Plain* x : {&lost_, &next_lost_, &end_, &next_end_}) *x = y;
    known_ = false;
  }
  /// A step starts from y.
  void begin(const Plain& y) {
    if (known_ && equal_blocks<S>(y, end_)) return;
    known_ = false;
    set_zero(Blocks<S>::all(lost_));
  }
  [[nodiscard]] const Plain& lost() const { return lost_; }
  [[nodiscard]] Plain& next_lost() { return next_lost_; }
  /// The step ends at `next`, with next_lost().
  void end(const Plain& next) { copy_blocks<S>(next_end_, next); }
  void accepted() {
    std::swap(lost_, next_lost_);
    std::swap(end_, next_end_);
    known_ = true;
  }
  void forget() { known_ = false; }
  void archive(auto& ar) {
    ar("known", known_);
    if (known_) ar.in_place("lost", lost_, "of", end_);
  }

 private:
  Plain lost_, next_lost_;
  Plain end_, next_end_;  // the states that they belong to
  bool known_ = false;
};

template <State S>
class CarriedRounding<S, false> {
 public:
  static constexpr bool is_kept = false;
  static void resize(const auto&) {}
  static void begin(const auto&) {}
  static void end(const auto&) {}
  static void accepted() {}
  static void forget() {}
  static void archive(auto&) {}
};

}}  // namespace phistep::PHISTEP_ABI
