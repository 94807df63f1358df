/// @file
/// Rows of linearly implicit Euler steps of few unknowns, several at a time. Within a row each substep waits for the one
/// before, for the latency of a force call and of a product with the inverse; rows don't wait for each other. So two or
/// three of them advance side by side, each with its own inverse of
///
///     W = M/h − C − hK,     W w = Ψ(t, y) + hKv,     v += w,  r += h v      (first order: W = M/h − J, y += w)  (1)
///
/// which divides (M − hC − h²K) w = h (Ψ + hKv) (Hairer & Wanner, Solving ODEs II, sect. IV.9) by h.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <utility>

#include "phistep/control/trace.hpp"
#include "phistep/core/arithmetic.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/version.hpp"
#include "phistep/linear/column.hpp"
#include "phistep/linear/dense_inverse.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Whether rows of this kernel run in lanes: a dense matrix of few unknowns, fixed in number.
template <State S, class Kernel>
inline constexpr bool runs_in_lanes = [] {
  if constexpr (requires(Kernel & kernel) { kernel.stages().matrix(); }) {
    using Matrix = std::remove_cvref_t<decltype(std::declval<Kernel&>().stages().matrix())>;
    if constexpr (Matrix::assembles) return static_unknowns<S> > 0 && static_unknowns<S> <= small_dense_limit;
    else return false;
  } else {
    return false;
  }
}();

template <State S, class Kernel>
class ImplicitEulerLanes {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Data = typename Kernel::Data;
  static constexpr int n = static_unknowns<S>;
  using Vector = Eigen::Matrix<Scalar, n, 1>;
  static constexpr bool drifts = Blocks<S>::drifts;
  /// Beyond, a substep keeps the arithmetic units busy by itself.
  static constexpr int lanes = n <= 4 ? 3 : n <= 8 ? 2 : 1;

  ImplicitEulerLanes(Kernel& kernel, Data& step, const Rate& start) : kernel_{kernel}, step_{step}, start_{start} {}

  /// ends[j] = T_{j,1} for from ≤ j ≤ to. @param theta  Newton's contraction rate where the step is watched (rows 1, 2)
  [[nodiscard]] Outcome run(auto& ends, const auto& substeps, int from, int to, double& theta) {
    const auto index = [](int j) { return static_cast<std::size_t>(j); };
    std::array<Lane, lanes> lane;
    // The longest rows first: the lanes then end together.
    int next = to, active = 0;
    for (; from <= 2 && from <= to; ++from) {
      if (const Outcome outcome = start(lane[0], from, substeps[index(from)], theta); outcome != Outcome::success)
        return outcome;
      if (theta > 1) return Outcome::success;
      while (lane[0].left > 0) substep(lane[0]);
      if (!finish(lane[0], ends[index(from)])) return failure(lane[0]);
    }
    for (; active < lanes && next >= from; ++active, --next)
      if (const Outcome outcome = start(lane[index(active)], next, substeps[index(next)], theta);
          outcome != Outcome::success)
        return outcome;
    while (active > 0) {
      int least = lane[0].left;
      for (int l = 1; l < active; ++l) least = std::min(least, lane[index(l)].left);
      if (active == 1) advance<1>(lane, least);
      if constexpr (lanes >= 2)
        if (active == 2) advance<2>(lane, least);
      if constexpr (lanes >= 3)
        if (active == 3) advance<3>(lane, least);
      for (int l = active - 1; l >= 0; --l) {
        Lane& done = lane[index(l)];
        if (done.left > 0) continue;
        if (!finish(done, ends[index(done.row)])) return failure(done);
        if (next >= from) {
          if (const Outcome outcome = start(done, next, substeps[index(next)], theta); outcome != Outcome::success)
            return outcome;
          --next;
        } else {
          --active;
          if (l != active) done = lane[index(active)];
        }
      }
    }
    return Outcome::success;
  }

 private:
  struct Lane {
    DenseInverse<Scalar, n> inverse;
    Plain y, moved;
    Scalar h;
    int row, left, done;
  };

  template <int count>
  void advance(std::array<Lane, lanes>& lane, int substeps) {
    for (int i = 0; i < substeps; ++i)
      [&]<int... l>(std::integer_sequence<int, l...>) { (substep(lane[l]), ...); }
      (std::make_integer_sequence<int, count>{});
  }

  /// The row's matrix and its first substep, whose Ψ is known; on a watched step's rows 1 and 2 also what Newton would
  /// correct it by (Hairer & Wanner's program): where that is no smaller, so is nothing that follows.
  [[nodiscard]] Outcome start(Lane& lane, int row, int substeps, double& theta) {
    const Scalar h = step_.dt / static_cast<Scalar>(substeps);
    lane.h = h;
    lane.row = row;
    lane.left = substeps;
    lane.done = 0;
    kernel_.stages().matrix().assemble(kernel_.rhs(), step_.y, 1 / h, h, lane.inverse.matrix());
    ++kernel_.rhs().statistics().factorizations;
    if (!lane.inverse.factorize()) return Outcome::singular_matrix;
    for_each_block([](auto, auto& to) { to.setZero(); }, Blocks<S>::all(lane.moved));
    copy_blocks<S>(lane.y, step_.y);
    Vector w;
    if constexpr (Kernel::has_time) {
      kernel_.evaluate(step_.t + h, lane.y, step_.psi);
      w = correction(lane, step_.psi);
    } else {
      w = correction(lane, start_);
    }
    move(lane, w);
    if (row > 2 || step_.trace == nullptr) return Outcome::success;
    Rate psi;
    kernel_.evaluate(step_.t + h, lane.y, psi);
    Vector residual;
    for_each_block(
        [&, at = Index{0}](auto, const auto& rate, const auto& mass) mutable {
          auto out = part(residual, at, rate);
          out = flat(rate);
          mass.subtract_product(part(w, at, rate) / h, out);
          at += rate.size();
        },
        Rate::blocks(std::as_const(psi)), kernel_.rhs().masses());
    ++kernel_.rhs().statistics().solves;
    lane.inverse.solve_in_place(residual);
    const double first = size_of(w, h), second = size_of(residual, h);
    const double rate = second / std::max(1.0, first);
    if (!(rate <= theta)) theta = rate <= 1 ? rate : 2;
    if (theta > 1) return Outcome::success;
    if constexpr (!Kernel::has_time) {
      w = correction(lane, psi);
      move(lane, w);
    }
    return Outcome::success;
  }
  void substep(Lane& lane) {
    Rate psi;
    kernel_.evaluate(step_.t + static_cast<Scalar>(lane.done + 1) * lane.h, lane.y, psi);
    const Vector w = correction(lane, psi);
    move(lane, w);
  }
  [[nodiscard]] Vector correction(const Lane& lane, const Rate& psi) {
    Vector w;
    for_each_block(
        [&, at = Index{0}](auto, const auto& rate) mutable {
          part(w, at, rate) = flat(rate);
          at += rate.size();
        },
        Rate::blocks(psi));
    if constexpr (drifts) kernel_.stages().matrix().add_position_product(lane.h, flat(velocity_of<S>(lane.y)), w);
    ++kernel_.rhs().statistics().solves;
    lane.inverse.solve_in_place(w);
    return w;
  }
  void move(Lane& lane, const Vector& w) {
    for_each_solved<S>([&](Index at, auto& by) { flat(by) += part(w, at, by); }, lane.moved);
    if constexpr (drifts) {
      velocity_of<S>(lane.y) = velocity_of<S>(step_.y) + velocity_of<S>(lane.moved);
      position_of<S>(lane.moved) += lane.h * velocity_of<S>(lane.y);
      position_of<S>(lane.y) = position_of<S>(step_.y) + position_of<S>(lane.moved);
    }
    for_each_block([](auto, auto& to, const auto& y, const auto& by) { to = y + by; }, Blocks<S>::solved(lane.y),
                   Blocks<S>::solved(step_.y), Blocks<S>::solved(std::as_const(lane.moved)));
    ++lane.done;
    --lane.left;
  }
  /// ‖(h w, w)‖, weighted as the error is
  [[nodiscard]] double size_of(const Vector& w, Scalar h) const {
    Plain x;
    for_each_solved<S>([&](Index at, auto& block) { flat(block) = part(w, at, block); }, x);
    if constexpr (drifts) position_of<S>(x) = h * velocity_of<S>(x);
    return weighted_rms(x, step_.trace->weight);
  }
  [[nodiscard]] bool finish(const Lane& lane, Plain& end) const {
    copy_blocks<S>(end, lane.moved);
    return Kernel::Rhs::is_finite(end);
  }
  /// For the message: Ψ where the row has broken down.
  [[nodiscard]] Outcome failure(const Lane& lane) {
    kernel_.evaluate(step_.t + step_.dt, lane.y, step_.psi);
    copy_blocks<S>(step_.next, lane.y);
    return Outcome::non_finite_state;
  }

  Kernel& kernel_;
  Data& step_;
  const Rate& start_;
};

}  // namespace phistep::inline PHISTEP_ABI
