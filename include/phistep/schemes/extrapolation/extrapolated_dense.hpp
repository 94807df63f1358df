/// @file
/// Rows of linearly implicit Euler steps (extrapolated_implicit.hpp) where W is a dense matrix of few unknowns: in lanes,
/// each with factors of its own.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "phistep/core/outcome.hpp"
#include "phistep/core/version.hpp"
#include "phistep/linear/column.hpp"
#include "phistep/linear/dense_lu.hpp"
#include "phistep/schemes/extrapolation/extrapolated_lanes.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Whether W is a dense matrix of few unknowns, fixed in number: each lane then has its own.
template <State S, class Kernel>
inline constexpr bool has_small_dense_stages = [] {
  using Matrix = std::remove_cvref_t<decltype(std::declval<Kernel&>().stages().matrix())>;
  if constexpr (Matrix::assembles) return static_unknowns<S> > 0 && static_unknowns<S> <= small_dense_limit;
  else return false;
}();

/// Rows of few unknowns, in lanes, with (1) and (2) of extrapolated_implicit.hpp divided by h: W = M/h − C − hK, kept as its inverse.
template <State S, class Kernel, class Inside>
class DenseImplicitEuler {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Data = RowData<Kernel>;
  static constexpr int n = static_unknowns<S>;
  using Vector = Eigen::Matrix<Scalar, n, 1>;
  using Inverse = DenseLu<Scalar, n>;
  static constexpr bool drifts = Blocks<S>::drifts;
  struct Fixed {
    Inverse inverse;
    Scalar h;
    Plain* record;  ///< null, or where the last increments go …
    int first;      ///< … from this substep on
  };
  struct Moving {
    Plain y, moved;
  };
  using LaneType = Lane<Fixed, Moving>;
  /// Beyond 8 unknowns a substep keeps the arithmetic units busy by itself.
  static constexpr int lanes = n <= 4 ? 3 : n <= 8 ? 2 : 1, alone = 2;
  static constexpr bool on_stack = true;

  DenseImplicitEuler(Kernel& kernel, Data& step, const Rate& start, Inside* inside)
      : kernel_{kernel}, step_{step}, start_{start}, inside_{inside} {}

  /// The row's matrix and its first substep, whose Ψ is known; on a watched step's rows 1 and 2 also what Newton would
  /// correct it by (Hairer & Wanner's program): where that is not smaller, later ones are not either.
  [[nodiscard]] Outcome start(LaneType& lane, int row, int substeps, double& theta) {
    auto& [inverse, h, record, first] = lane.fixed;
    auto& [y, moved] = lane.moving;
    h = step_.dt / static_cast<Scalar>(substeps);
    record = inside_ != nullptr ? inside_->row(row) : nullptr;
    first = substeps - row;
    kernel_.stages().matrix().assemble(kernel_.rhs(), step_.y, 1 / h, h, inverse.matrix());
    ++kernel_.rhs().statistics().factorizations;
    if (!inverse.factorize()) return Outcome::singular_matrix;
    for_each_block([](auto, auto& to) { to.setZero(); }, Blocks<S>::all(moved));
    copy_blocks<S>(y, step_.y);
    Vector w;
    if constexpr (Kernel::has_time) {
      kernel_.evaluate(step_.t + h, y, step_.psi);
      w = correction(inverse, h, y, step_.psi);
    } else {
      w = correction(inverse, h, y, start_);
    }
    move(lane.fixed, lane.done, w, lane.moving);
    ++lane.done, --lane.left;
    if (row > 2 || step_.trace == nullptr) return Outcome::success;
    Rate psi;
    kernel_.evaluate(step_.t + h, y, psi);
    Vector residual;
    for_each_block(
        [&, h = h, at = Index{0}](auto, const auto& rate, const auto& mass) mutable {
          auto out = part(residual, at, rate);
          out = flat(rate);
          mass.subtract_product(part(w, at, rate) / h, out);
          at += rate.size();
        },
        Rate::blocks(std::as_const(psi)), kernel_.rhs().masses());
    ++kernel_.rhs().statistics().solves;
    inverse.solve_in_place(residual);
    // θ² = ‖next‖²/max(1, ‖w‖²)
    const double next = square_of(residual, h), size = std::max(count_of(), square_of(w, h));
    if (!(next <= size)) {
      theta = 2;
      return Outcome::success;
    }
    if constexpr (!Kernel::has_time) {
      w = correction(inverse, h, y, psi);
      move(lane.fixed, lane.done, w, lane.moving);
      ++lane.done, --lane.left;
    }
    return Outcome::success;
  }
  [[gnu::always_inline]] void substep(const Fixed& fixed, int done, Moving& moving) {
    Rate psi;
    kernel_.evaluate(step_.t + static_cast<Scalar>(done + 1) * fixed.h, moving.y, psi);
    move(fixed, done, correction(fixed.inverse, fixed.h, moving.y, psi), moving);
  }
  [[nodiscard]] Outcome finish(const LaneType& lane, Plain& end) {
    copy_blocks<S>(end, lane.moving.moved);
    if (Kernel::Rhs::is_finite(end)) return Outcome::success;
    // For the message: Ψ where the row has broken down.
    kernel_.evaluate(step_.t + step_.dt, lane.moving.y, step_.psi);
    copy_blocks<S>(step_.next, lane.moving.y);
    return Outcome::non_finite_state;
  }

 private:
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
  [[gnu::always_inline]] void move(const Fixed& fixed, int done, const Vector& w, Moving& moving) {
    for_each_solved<S>(
        [&](Index at, auto& to, auto& by, const auto& from) {
          for (Index i = 0; i < by.size(); ++i) {
            by.data()[i] += w[at + i];
            to.data()[i] = from.data()[i] + by.data()[i];
          }
        },
        moving.y, moving.moved, step_.y);
    if constexpr (drifts) {
      position_of<S>(moving.moved) += fixed.h * velocity_of<S>(moving.y);
      position_of<S>(moving.y) = position_of<S>(step_.y) + position_of<S>(moving.moved);
    }
    if (fixed.record != nullptr && done >= fixed.first) {
      Plain& last = fixed.record[done - fixed.first];
      for_each_solved<S>([&](Index at, auto& to) { flat(to) = part(w, at, to); }, last);
      if constexpr (drifts) position_of<S>(last) = fixed.h * velocity_of<S>(moving.y);
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

  Kernel& kernel_;
  Data& step_;
  const Rate& start_;  // Ψ(t, y)
  Inside* inside_;     // null: no dense output
};

}}  // namespace phistep::PHISTEP_ABI
