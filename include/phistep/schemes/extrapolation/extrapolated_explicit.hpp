/// @file
/// Explicit bases of extrapolation whose error has even powers of h alone, so that each column gains two orders.
///
/// Gragg's rule, the explicit midpoint rule after a step of forward Euler, n even (W. B. Gragg, SIAM J. Numer. Anal. 2
/// (1965) 384; Hairer, Nørsett & Wanner, Solving ODEs I, sect. II.9):
///
///     z_1 = y + h f(y),     z_{i+1} = z_{i−1} + 2h f(z_i),     T = z_n − y                                      (1)
///
/// Velocity Verlet, for r'' = a(t, r), any n (sect. II.14; Störmer's rule, summed):
///
///     v_½ = v + ½h a(r),   r_{i+1} = r_i + h v_{i+½},   v_{i+½} = v_{i−½} + h a(r_i),   v_n = v_{n+½} − ½h a(r_n) (2)
///
/// Both are summed as increments from y: what extrapolation amplifies is then the rounding of the increments.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "phistep/core/outcome.hpp"
#include "phistep/core/version.hpp"
#include "phistep/schemes/extrapolation/extrapolated_lanes.hpp"
#include "phistep/schemes/extrapolation/extrapolation_table.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What the two have in common. @tparam Rule  (1) or (2)
template <State S, class Kernel, class Rule>
class ExplicitRows {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Data = RowData<Kernel>;
  using Fixed = Scalar;  // h
  using Moving = typename Rule::Moving;
  using LaneType = Lane<Fixed, Moving>;
  static constexpr int size = static_size<decltype(Blocks<S>::all(std::declval<Plain&>()))>;
  static constexpr bool on_stack = size != Eigen::Dynamic && size <= 64;
  static constexpr int lanes = on_stack && size <= 4 ? 3 : on_stack && size <= 8 ? 2 : 1, alone = 1;

  ExplicitRows(Kernel& kernel, Data& step, const Plain& slope, Plain& slopes)
      : kernel_{kernel}, step_{step}, slope_{slope}, slopes_{slopes} {}

  /// Row 1 also looks whether y' changes within a substep by more than twice itself: h then lies beyond the rows'
  /// stability, where their agreement may be an accident (Hairer & Wanner's program ODEX).
  [[nodiscard]] Outcome start(LaneType& lane, int row, int substeps, double& theta) {
    lane.fixed = step_.dt / static_cast<Scalar>(substeps);
    lane.left -= Rule::start(lane.fixed, step_.y, slope_, lane.moving);
    lane.done = substeps - lane.left;
    if (row > 1 || step_.trace == nullptr) return Outcome::success;
    const auto look = [&](Plain& slope) {
      evaluate(lane.fixed, lane.done, lane.moving, slope);
      theta = change(lane.fixed, slope) / 2;
      if (!(theta <= 1)) theta = 2;
      Rule::move(lane.fixed, step_.y, slope, lane.moving);
    };
    if constexpr (on_stack) {
      Plain slope;
      look(slope);
    } else {
      look(slopes_);
    }
    ++lane.done, --lane.left;
    return Outcome::success;
  }
  [[gnu::always_inline]] void substep(const Scalar& h, int done, Moving& moving) {
    const auto next = [&](Plain& slope) {
      evaluate(h, done, moving, slope);
      Rule::move(h, step_.y, slope, moving);
    };
    if constexpr (on_stack) {
      Plain slope;
      next(slope);
    } else {
      next(slopes_);
    }
  }
  [[nodiscard]] Outcome finish(LaneType& lane, Plain& end) {
    Rule::finish(lane.fixed, lane.moving, end);
    if (Kernel::Rhs::is_finite(end)) return Outcome::success;
    copy_blocks<S>(step_.next, lane.moving.y);
    return Outcome::non_finite_state;
  }

 private:
  void evaluate(Scalar h, int done, Moving& moving, Plain& slope) {
    const Plain& y = Rule::where(h, step_.y, moving);
    // What isn't finite shows at the row's end.
    static_cast<void>(kernel_.rhs().slope(step_.t + static_cast<Scalar>(done + Rule::ahead) * h, y, slope, step_.psi));
  }
  /// ‖h (y' − y'(t))‖ / max(1, ‖h y'(t)‖)
  [[nodiscard]] double change(Scalar h, const Plain& slope) const {
    using Wide = std::common_type_t<Scalar, double>;
    Wide changed{0}, first{0};
    Index n = 0;
    for_each_block(
        [&](auto, const auto& f, const auto& f0, const auto& weight) {
          for (Index i = 0; i < f.size(); ++i) {
            const Scalar w = h * weight.data()[i];
            const Wide a = static_cast<Wide>(w * (f.data()[i] - f0.data()[i])), b = static_cast<Wide>(w * f0.data()[i]);
            changed += a * a;
            first += b * b;
          }
          n += f.size();
        },
        Blocks<S>::all(slope), Blocks<S>::all(slope_), Blocks<S>::all(step_.trace->weight));
    return std::sqrt(static_cast<double>(changed / std::max(static_cast<Wide>(n), first)));
  }

  Kernel& kernel_;
  Data& step_;
  const Plain& slope_;
  Plain& slopes_;
};

/// (1)
template <State S>
struct GraggRule {
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  static constexpr int ahead = 0;
  struct Moving {
    Plain y, moved, before;  ///< z_i, z_i − y and z_{i−1} − y
  };
  static void resize(const Plain& y, Moving& m) { m.y = m.moved = m.before = y; }
  static int start(Scalar h, const Plain& y, const Plain& slope, Moving& m) {
    for_each_block(
        [h](auto, auto& z, auto& moved, auto& before, const auto& from, const auto& f) {
          before.setZero(from.rows(), from.cols());
          moved = h * f;
          z = from + moved;
        },
        Blocks<S>::all(m.y), Blocks<S>::all(m.moved), Blocks<S>::all(m.before), Blocks<S>::all(y),
        Blocks<S>::all(slope));
    return 1;
  }
  [[nodiscard]] static const Plain& where(Scalar, const Plain&, Moving& m) { return m.y; }
  static void move(Scalar h, const Plain& y, const Plain& slope, Moving& m) {
    for_each_block(
        [by = 2 * h](auto, auto& z, auto& moved, auto& before, const auto& from, const auto& f) {
          for (Index i = 0; i < z.size(); ++i) {
            const Scalar next = before.data()[i] + by * f.data()[i];
            before.data()[i] = moved.data()[i];
            moved.data()[i] = next;
            z.data()[i] = from.data()[i] + next;
          }
        },
        Blocks<S>::all(m.y), Blocks<S>::all(m.moved), Blocks<S>::all(m.before), Blocks<S>::all(y),
        Blocks<S>::all(slope));
  }
  static void finish(Scalar, const Moving& m, Plain& end) { copy_blocks<S>(end, m.moved); }
};

/// (2)
template <State S>
struct VerletRule {
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  static constexpr int ahead = 1;
  using Block = std::remove_cvref_t<decltype(velocity_of<S>(std::declval<Plain&>()))>;
  struct Moving {
    Plain y, moved;      ///< (r_i, v_{i+½}), and that from the start
    Block acceleration;  ///< the last
  };
  static void resize(const Plain& y, Moving& m) {
    m.y = m.moved = y;
    m.acceleration = velocity_of<S>(y);
  }
  static int start(Scalar h, const Plain& y, const Plain& slope, Moving& m) {
    copy_blocks<S>(m.y, y);
    position_of<S>(m.moved).setZero(position_of<S>(y).rows(), position_of<S>(y).cols());
    velocity_of<S>(m.moved) = (h / 2) * velocity_of<S>(slope);
    velocity_of<S>(m.y) = velocity_of<S>(y) + velocity_of<S>(std::as_const(m.moved));
    return 0;
  }
  [[nodiscard]] static const Plain& where(Scalar h, const Plain& y, Moving& m) {
    auto &r = position_of<S>(m.y), &moved = position_of<S>(m.moved);
    const auto &v = velocity_of<S>(m.y), &from = position_of<S>(y);
    for (Index i = 0; i < r.size(); ++i) {
      moved.data()[i] += h * v.data()[i];
      r.data()[i] = from.data()[i] + moved.data()[i];
    }
    return m.y;
  }
  static void move(Scalar h, const Plain& y, const Plain& slope, Moving& m) {
    auto &v = velocity_of<S>(m.y), &moved = velocity_of<S>(m.moved);
    const auto &a = velocity_of<S>(slope), &from = velocity_of<S>(y);
    for (Index i = 0; i < v.size(); ++i) {
      moved.data()[i] += h * a.data()[i];
      v.data()[i] = from.data()[i] + moved.data()[i];
    }
    m.acceleration = a;
  }
  static void finish(Scalar h, const Moving& m, Plain& end) {
    copy_blocks<S>(end, m.moved);
    velocity_of<S>(end) -= (h / 2) * m.acceleration;
  }
};

/// The base method as a row of extrapolation sees it.
template <State S, template <State> class Rule>
class ExplicitBase {
 public:
  using Plain = PlainState<S>;
  static constexpr int power = 2;
  static constexpr bool interpolates = false;
  template <class Rhs>
  static constexpr bool needs_stages = false;
  /// The call at the start serves all rows.
  static constexpr double row_work = 0;

  void resize(const Plain& y) {
    slope_ = slopes_ = y;
    if constexpr (!on_stack) Rule<S>::resize(y, lane_[0].moving);
  }
  template <class Kernel>
  [[nodiscard]] Outcome begin(Kernel& kernel, RowData<Kernel>& step) {
    if (kernel.rhs().slope(step.t, step.y, slope_, step.psi)) return Outcome::success;
    copy_blocks<S>(step.next, step.y);
    return Outcome::non_finite_force;
  }
  template <class Kernel>
  [[nodiscard]] Outcome rows(Kernel& kernel, RowData<Kernel>& step, auto& ends, const auto& substeps, int from, int to,
                             double& theta, auto* /*inside*/) {
    using LaneMethod = ExplicitRows<S, Kernel, Rule<S>>;
    LaneMethod method{kernel, step, slope_, slopes_};
    if constexpr (LaneMethod::on_stack) {
      std::array<typename LaneMethod::LaneType, LaneMethod::lanes> lanes;
      return RowLanes{method, lanes}.run(ends, substeps, from, to, theta);
    } else {
      return RowLanes{method, lane_}.run(ends, substeps, from, to, theta);
    }
  }

 private:
  static constexpr int size = static_size<decltype(Blocks<S>::all(std::declval<Plain&>()))>;
  static constexpr bool on_stack = size != Eigen::Dynamic && size <= 64;
  struct Nothing {};
  Plain slope_, slopes_;
  [[no_unique_address]] std::conditional_t<on_stack, Nothing,
                                           std::array<Lane<ScalarOf<S>, typename Rule<S>::Moving>, 1>>
      lane_;
};

template <State S>
class GraggBase : public ExplicitBase<S, GraggRule> {
 public:
  template <int columns>
  static constexpr auto numbers = even_numbers<columns>();
};
template <State S>
class VerletBase : public ExplicitBase<S, VerletRule> {
 public:
  template <int columns>
  static constexpr auto numbers = even_numbers<columns>();
  template <class Rhs>
  static constexpr bool needs_stages = [] {
    static_assert(
        !Rhs::couples_unknowns,
        "phistep: extrapolated(velocity_verlet) needs a force that ignores v; take extrapolated(forward_euler)");
    return false;
  }();
};

}}  // namespace phistep::PHISTEP_ABI
