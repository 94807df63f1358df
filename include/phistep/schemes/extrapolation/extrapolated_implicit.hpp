/// @file
/// Linearly implicit Euler as the base of extrapolation: with one Jacobian for all rows of a step,
///
///     (M − hJ) δ = h Ψ(t + (i+1)h, y_i),     y_{i+1} = y_i + δ                                                  (1)
///
/// For motion, n equations, not 2n (Hairer & Wanner, Solving ODEs II, sect. IV.9):
///
///     (M − hC − h²K) w = h (Ψ + hKv),     v += w,  r += h v                                                     (2)
///
/// In the stiff limit the expansion in h holds where the first substeps contract. So in rows 1 and 2, what Newton would
/// correct the first substep by is compared with it: θ > 1 ends the step (their program's test).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "phistep/core/outcome.hpp"
#include "phistep/core/version.hpp"
#include "phistep/schemes/extrapolation/extrapolated_dense.hpp"
#include "phistep/schemes/extrapolation/extrapolated_lanes.hpp"
#include "phistep/schemes/extrapolation/extrapolation_table.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Rows of any size and structure, one after the other, by the kernel's linear stages.
template <State S, class Kernel, class Inside>
class ImplicitEulerRows {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Data = RowData<Kernel>;

  ImplicitEulerRows(Kernel& kernel, Data& step, Plain& delta, const RateOf<S>& start, Inside* inside)
      : kernel_{kernel}, step_{step}, delta_{delta}, start_{start}, inside_{inside} {}

  /// ends[j] = T_{j,1} for from ≤ j ≤ to
  [[nodiscard]] Outcome run(auto& ends, const auto& substeps, int from, int to, double& theta) {
    for (int j = from; j <= to && theta <= 1; ++j) {
      const auto index = static_cast<std::size_t>(j);
      if (const Outcome outcome = row(ends[index], substeps[index], j, theta); outcome != Outcome::success)
        return outcome;
    }
    return Outcome::success;
  }

 private:
  [[nodiscard]] Outcome row(Plain& moved, int substeps, int j, double& theta) {
    const Scalar h = step_.dt / static_cast<Scalar>(substeps);
    if (const Outcome outcome = kernel_.factorize(h); outcome != Outcome::success) return outcome;
    for_each_block([](auto, auto& to) { to.setZero(); }, Blocks<S>::all(moved));
    bool known = !Kernel::has_time;
    if (known) copy_rate(step_.psi, start_);
    for (int i = 0; i < substeps; ++i) {
      place(moved);
      if (!std::exchange(known, false))
        kernel_.evaluate(step_.t + static_cast<Scalar>(i + 1) * h, step_.next, step_.psi);
      right_hand_side(h);
      if (const Outcome outcome = kernel_.solve(h, delta_); outcome != Outcome::success) return outcome;
      for_each_block([](auto, auto& to, const auto& by) { to += by; }, Blocks<S>::all(moved),
                     Blocks<S>::all(std::as_const(delta_)));
      if (inside_ != nullptr && i >= substeps - j) copy_blocks<S>(inside_->row(j)[i - (substeps - j)], delta_);
      if (i == 0 && j <= 2 && step_.trace != nullptr) {
        if (const Outcome outcome = contraction(moved, h, theta); outcome != Outcome::success) return outcome;
        if (theta > 1) return Outcome::success;
        known = !Kernel::has_time;
      }
    }
    if (Kernel::Rhs::is_finite(moved)) return Outcome::success;
    return Outcome::non_finite_state;
  }
  /// next = y + moved
  void place(const Plain& moved) {
    for_each_block([](auto, auto& to, const auto& y, const auto& by) { to = y + by; }, Blocks<S>::all(step_.next),
                   Blocks<S>::all(step_.y), Blocks<S>::all(moved));
  }
  void right_hand_side(Scalar h) {
    if constexpr (Blocks<S>::drifts) position_of<S>(delta_) = h * velocity_of<S>(std::as_const(step_.next));
    for_each_block([h](auto, auto& to, const auto& psi) { to = h * psi; }, Blocks<S>::solved(delta_),
                   RateOf<S>::blocks(std::as_const(step_.psi)));
  }
  /// What Newton's second correction would be, beside the first, δ.
  [[nodiscard]] Outcome contraction(const Plain& moved, Scalar h, double& theta) {
    place(moved);
    kernel_.evaluate(step_.t + h, step_.next, step_.psi);
    const double first = weighted_rms(delta_, step_.trace->weight);
    if constexpr (Blocks<S>::drifts) position_of<S>(delta_).setZero();
    for_each_block([h](auto, auto& to, const auto& psi) { to = h * psi; }, Blocks<S>::solved(delta_),
                   RateOf<S>::blocks(std::as_const(step_.psi)));
    kernel_.add_mass_product(delta_, Scalar{-1}, moved);
    if (const Outcome outcome = kernel_.solve(h, delta_); outcome != Outcome::success) return outcome;
    const double rate = weighted_rms(delta_, step_.trace->weight) / std::max(1.0, first);
    if (!(rate <= theta)) theta = rate <= 1 ? rate : 2;
    return Outcome::success;
  }

  Kernel& kernel_;
  Data& step_;
  Plain& delta_;
  const RateOf<S>& start_;
  Inside* inside_;
};

/// The base method as a row of extrapolation sees it.
template <State S>
class ImplicitEulerBase {
 public:
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  static constexpr int power = 1;
  static constexpr bool interpolates = true;
  template <class Rhs>
  static constexpr bool needs_stages = true;
  template <int columns>
  static constexpr auto numbers = bulirsch_numbers<columns>();
  /// What a row costs beside its substeps, in substeps (a force call and a solve): a factorization (bench/small_dense).
  static constexpr double row_work = [] {
    constexpr int n = static_unknowns<S>;
    return n == Eigen::Dynamic ? 8 : n <= 2 ? 2 : n <= 8 ? 4 : 10;
  }();

  void resize(const Plain& y) { delta_ = y, start_ = make_rate<S>(y); }
  template <class Kernel>
  [[nodiscard]] Outcome begin(Kernel& kernel, RowData<Kernel>& step) {
    if (const Outcome outcome = kernel.linearise(step); outcome != Outcome::success) return outcome;
    copy_rate(start_, step.psi);
    return Outcome::success;
  }
  /// ends[j] = T_{j,1} for from ≤ j ≤ to, unless theta > 1
  template <class Kernel>
  [[nodiscard]] Outcome rows(Kernel& kernel, RowData<Kernel>& step, auto& ends, const auto& substeps, int from, int to,
                             double& theta, auto* inside) {
    using Inside = std::remove_pointer_t<decltype(inside)>;
    if constexpr (has_small_dense_stages<S, Kernel>) {
      using LaneMethod = DenseImplicitEuler<S, Kernel, Inside>;
      LaneMethod method{kernel, step, start_, inside};
      std::array<typename LaneMethod::LaneType, LaneMethod::lanes> lanes;
      return RowLanes{method, lanes}.run(ends, substeps, from, to, theta);
    } else {
      return ImplicitEulerRows<S, Kernel, Inside>{kernel, step, delta_, start_, inside}.run(ends, substeps, from, to,
                                                                                            theta);
    }
  }

 private:
  Plain delta_;
  Rate start_;  // Ψ(t, y)
};

}}  // namespace phistep::PHISTEP_ABI
