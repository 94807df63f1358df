/// @file
/// K = ∂Ψ/∂r and C = ∂Ψ/∂v (or ∂Ψ/∂y) of a bound force by differences, with increments scaled by what a step moves: a force
/// call a column, or a call a colour (step/jacobian/coloring.hpp) where the force says which rows a column has.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/machine/only.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/annotate.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/jacobian/coloring.hpp"
#include "phistep/step/jacobian/differences.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State S, class Rhs, bool has_K, bool has_C>
class DifferenceTangent {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Unknown = Eigen::Matrix<Scalar, static_unknowns<S>, 1>;
  static constexpr bool patterned = Rhs::Traits::has_pattern;

  /// @throws std::invalid_argument where the force's pattern doesn't fit y
  void resize(const Plain& y, [[maybe_unused]] Rhs& rhs) {
    if constexpr (patterned) columns_.resize(rhs, unknowns<S>(y));
    probe_ = y;
    probe_rate_ = make_rate<S>(y);
  }
  /// The force may be another one: so may its pattern.
  void forget_pattern() {
    if constexpr (patterned) columns_.fresh = false;
  }
  /// A new solve: nothing is known of how far it moves.
  void begin() { kick_limit_.fill(std::numeric_limits<double>::infinity()); }

  /// Puts K and C at (t, Y), where Ψ is psi, into the system.
  void compute(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, const Plain& Y, const Rate& psi,
               const NewtonOptions& options, const SolveTolerance<Plain>& allowed, auto& system) {
    copy_blocks<S>(probe_, Y);
    if constexpr (patterned)
      if (!columns_.fresh) columns_.resize(rhs, unknowns<S>(Y));
    if constexpr (has_K) {
      std::array<Scalar, Rhs::blocks> scale{};
      // The tolerance is one for the unknowns, v: r may be off by what v's error moves it.
      const double time = std::abs(static_cast<double>(gamma.drift));
      const double kicked = kick_of(gamma, std::get<0>(Rate::blocks(psi)), std::get<0>(rhs.masses()));
      scale[0] =
          scale_of(position_of<S>(Y), time * largest(velocity_of<S>(Y)), time * kicked, options, time * options.atol);
      const auto entry = [&system](Index i, Index j, Scalar x) { system.position(i, j, x); };
      const auto scales = [&](auto k, Index i) {
        return allowed.target > 0 ? told(position_of<S>(*allowed.weight), i, allowed.rtol, scale[k]) : scale[k];
      };
      difference(rhs, t, std::tie(position_of<S>(probe_)), std::tie(position_of<S>(Y)), scales, psi, entry);
    }
    if constexpr (has_C) {
      std::array<Scalar, Rhs::blocks> scale{};
      for_each_block(
          [&](auto k, const auto& block, const auto& rate, const auto& mass) {
            double fallback = 0;
            if constexpr (Rhs::drifts && k == 0)
              if (gamma.drift != Scalar{0})
                fallback = largest(position_of<S>(Y)) / std::abs(static_cast<double>(gamma.drift));
            const double kicked = std::min(kick_of(gamma, rate, mass), kick_limit_[k]);
            kick_used_[k] = kicked;
            scale[k] = scale_of(block, kicked, fallback, options, options.atol);
          },
          Blocks<S>::solved(Y), Rate::blocks(psi), rhs.masses());
      const auto entry = [&system](Index i, Index j, Scalar x) { system.velocity(i, j, x); };
      const auto scales = [&](auto k, Index i) {
        if (!(allowed.target > 0)) return scale[k];
        return told(std::get<k()>(Blocks<S>::solved(*allowed.weight)), i, allowed.rtol, scale[k]);
      };
      difference(rhs, t, Blocks<S>::solved(probe_), Blocks<S>::solved(Y), scales, psi, entry);
    }
  }

  /// A stiff force kicks far and moves little: differences over the kick then miss the tangent. True once per block and
  /// matrix that did so, with the next differences confined to what Y and δ say.
  [[nodiscard]] bool reached_too_far(const Plain& Y, const Unknown& correction) {
    if constexpr (Rhs::Traits::is_affine) return false;
    bool too_far = false;
    std::size_t k = 0;
    for_each_solved<S>(
        [&](Index at, const auto& y) {
          const double size = std::max(largest(y), largest(part(correction, at, y)));
          if (size > 0 && kick_used_[k] > 16 * size) {
            too_far = true;
            kick_limit_[k] = size;
          }
          kick_used_[k++] = 0;
        },
        Y);
    return too_far;
  }

 private:
  /// What counts as a usual size of a block's components: what they are, or how far a step moves them.
  [[nodiscard]] static Scalar scale_of(const auto& block, double moved, double fallback, const NewtonOptions& options,
                                       double atol) {
    double scale = std::max(largest(block), moved);
    if (scale == 0) scale = fallback;
    if (options.rtol > 0) scale = 16 * atol / options.rtol;
    return static_cast<Scalar>(scale > 0 ? scale : 1.0);
  }

  /// … of a component, where a controlled run says it: |y| + atol/rtol.
  [[nodiscard]] static Scalar told(const auto& weight, Index i, double rtol, Scalar otherwise) {
    const Scalar w = weight.data()[i];
    return w > 0 ? Scalar{16} / (static_cast<Scalar>(rtol) * w) : otherwise;
  }
  /// How far γΨ/M kicks a block, its farthest component.
  [[nodiscard]] static double kick_of(const Gamma<Scalar>& gamma, const auto& rate, const auto& mass) {
    double kicked = 0;
    const auto factor = mass.scaled(gamma.force);
    for (Index i = 0; i < rate.size(); ++i)
      kicked = std::max(kicked, std::abs(static_cast<double>(factor(i) * rate.data()[i])));
    return kicked;
  }

  /// Differences over the components of `moved`, which are blocks of the probe and equal `still`; each entry to put.
  void difference(Rhs& rhs, Scalar t, const auto& moved, const auto& still, const auto& scale, const Rate& psi,
                  auto&& put) {
    if constexpr (patterned) {
      for (Index color = 0; color < columns_.coloring.colors(); ++color) {
        if (!move(color, moved, scale)) continue;
        rhs.evaluate_into(t, probe_, probe_rate_);
        for_each_rate(psi, [this](Index i, Scalar now, Scalar before) { columns_.change[i] = now - before; });
        for_each_moved(color, moved, [&](auto, Index j, Index) {
          columns_.for_each_row(j, [&](Index i) { put(i, j, columns_.change[i] / columns_.increment[j]); });
        });
        for_each_block([](auto, auto& to, const auto& from) { to = from; }, moved, still);
      }
    } else {
      Index at = 0;
      for_each_block(
          [&](auto k, auto& block) {
            for_each_difference<Rhs::Traits::is_affine>(
                block, [&](Index i) { return scale(k, i); },
                [&](Index j, Scalar increment) {
                  rhs.evaluate_into(t, probe_, probe_rate_);
                  for_each_rate(
                      psi, [&](Index i, Scalar now, Scalar before) { put(i, at + j, (now - before) / increment); });
                });
            at += block.size();
          },
          moved);
    }
  }
  /// f(i, Ψ_i of the probe, Ψ_i of psi)
  void for_each_rate(const Rate& psi, auto&& f) const {
    for_each_number([&f](std::size_t i, Scalar now, Scalar before) { f(static_cast<Index>(i), now, before); },
                    Rate::blocks(probe_rate_), Rate::blocks(psi));
  }
  /// f(block, column, component of the block) for a colour's columns that lie in the blocks.
  void for_each_moved(Index color, const auto& blocks, auto&& f) const {
    const auto columns = columns_.coloring.columns(color);
    const Index* next = columns.begin();
    Index at = 0;
    for_each_block(
        [&](auto k, auto& block) {
          for (; next != columns.end() && *next < at + block.size(); ++next) f(k, *next, *next - at);
          at += block.size();
        },
        blocks);
  }
  /// Moves a colour's components. False: it has none here.
  [[nodiscard]] bool move(Index color, const auto& blocks, const auto& scale) {
    bool any = false;
    for_each_moved(color, blocks, [&](auto k, Index j, Index i) {
      columns_.increment[j] = move_by_increment<Rhs::Traits::is_affine>(std::get<k>(blocks).data()[i], scale(k, i));
      any = true;
    });
    return any;
  }

  /// The force's pattern and what differences by colour work with.
  struct Columns {
    ColumnPattern pattern;
    ColumnColoring<> coloring;
    Unknown increment, change;
    bool fresh = false;

    void resize(Rhs& rhs, Index n) {
      const ColumnPattern& now = rhs.force().pattern(n);
      if (coloring.colors() == 0 || now.start != pattern.start || now.row != pattern.row) {
        coloring = ColumnColoring<>(now, n);
        pattern = now;
      }
      increment.setZero(n);
      change.setZero(n);
      fresh = true;
    }
    void for_each_row(Index j, auto&& f) const {
      const auto first = pattern.start[static_cast<std::size_t>(j)],
                 last = pattern.start[static_cast<std::size_t>(j) + 1];
      for (Index p = first; p < last; ++p) f(pattern.row[static_cast<std::size_t>(p)]);
    }
  };

  Plain probe_;
  Rate probe_rate_;
  [[no_unique_address]] Only<patterned, Columns> columns_;
  std::array<double, Rhs::blocks> kick_used_{}, kick_limit_{};  // how far differences reached, and may reach
};

}}  // namespace phistep::PHISTEP_ABI
