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
      advance<1>(lane, lane[0].left);
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
  using Inverse = DenseInverse<Scalar, n>;
  struct Lane {
    Inverse inverse;
    Plain y, moved;
    Scalar h;
    int row, left, done;
  };

  /// What moves is taken into variables of its own: numbers stored one by one can't be loaded as a packet at once.
  template <int count>
  [[gnu::flatten, gnu::noinline]] void advance(std::array<Lane, lanes>& lane, int substeps) {
    [&]<std::size_t... l>(std::index_sequence<l...>) {
      std::array<Plain, count> y{lane[l].y...}, moved{lane[l].moved...};
      const std::array<Scalar, count> h{lane[l].h...};
      for (int i = 0; i < substeps; ++i) (substep(lane[l].inverse, h[l], lane[l].done + i, y[l], moved[l]), ...);
      ((lane[l].y = y[l], lane[l].moved = moved[l], lane[l].done += substeps, lane[l].left -= substeps), ...);
    }
    (std::make_index_sequence<count>{});
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
      w = correction(lane.inverse, h, lane.y, step_.psi);
    } else {
      w = correction(lane.inverse, h, lane.y, start_);
    }
    move(h, w, lane.y, lane.moved);
    ++lane.done, --lane.left;
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
    // θ² = ‖second‖²/max(1, ‖first‖²)
    const double second = square_of(residual, h), first = std::max(count_of(), square_of(w, h));
    if (!(second <= first)) {
      theta = 2;
      return Outcome::success;
    }
    if constexpr (!Kernel::has_time) {
      w = correction(lane.inverse, h, lane.y, psi);
      move(h, w, lane.y, lane.moved);
      ++lane.done, --lane.left;
    }
    return Outcome::success;
  }
  [[gnu::always_inline]] void substep(const Inverse& inverse, Scalar h, int done, Plain& y, Plain& moved) {
    Rate psi;
    kernel_.evaluate(step_.t + static_cast<Scalar>(done + 1) * h, y, psi);
    move(h, correction(inverse, h, y, psi), y, moved);
  }
  [[nodiscard, gnu::always_inline]] Vector correction(const Inverse& inverse, Scalar h, const Plain& y,
                                                      const Rate& psi) {
    Vector w;
    for_each_block(
        [&, at = Index{0}](auto, const auto& rate) mutable {
          for (Index i = 0; i < rate.size(); ++i) w[at + i] = rate.data()[i];
          at += rate.size();
        },
        Rate::blocks(psi));
    if constexpr (drifts) kernel_.stages().matrix().add_position_product(h, flat(velocity_of<S>(y)), w);
    ++kernel_.rhs().statistics().solves;
    inverse.solve_in_place(w);
    return w;
  }
  [[gnu::always_inline]] void move(Scalar h, const Vector& w, Plain& y, Plain& moved) {
    for_each_solved<S>(
        [&](Index at, auto& to, auto& by, const auto& from) {
          for (Index i = 0; i < by.size(); ++i) {
            by.data()[i] += w[at + i];
            to.data()[i] = from.data()[i] + by.data()[i];
          }
        },
        y, moved, step_.y);
    if constexpr (drifts) {
      position_of<S>(moved) += h * velocity_of<S>(y);
      position_of<S>(y) = position_of<S>(step_.y) + position_of<S>(moved);
    }
  }
  /// n ‖(h w, w)‖², weighted as the error is
  [[nodiscard]] double square_of(const Vector& w, Scalar h) const {
    using Wide = std::common_type_t<Scalar, double>;
    Wide sum{0};
    const auto add = [&sum](Scalar x) { sum += static_cast<Wide>(x) * static_cast<Wide>(x); };
    const Plain& weight = step_.trace->weight;
    for_each_solved<S>(
        [&](Index at, const auto& by) {
          for (Index i = 0; i < by.size(); ++i) add(w[at + i] * by.data()[i]);
        },
        weight);
    if constexpr (drifts) {
      const auto& by = position_of<S>(weight);
      for (Index i = 0; i < by.size(); ++i) add(h * w[i] * by.data()[i]);
    }
    return static_cast<double>(sum);
  }
  [[nodiscard]] static double count_of() {
    return static_cast<double>(static_size<decltype(Blocks<S>::all(std::declval<Plain&>()))>);
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
