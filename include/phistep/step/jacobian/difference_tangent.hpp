/// @file
/// K = ∂Ψ/∂r and C = ∂Ψ/∂v (or ∂Ψ/∂y) of a bound force by differences, with increments scaled by what a step moves: a force
/// call a column, or, where the force says which rows a column has, a call a group of columns no two of which share a row.
///
/// Moving all of a group's components at once changes each row by the part of one column alone (Curtis, Powell & Reid, J. Inst. Math.
/// Appl. 13 (1974) 117). The fewest groups are a colouring of the columns' intersection graph; greedy colouring takes each
/// column in turn and gives it the first colour that no neighbour has, which is optimal for a band in natural order and good elsewhere
/// with the columns of most neighbours first (Coleman & Moré, SIAM J. Numer. Anal. 20 (1983) 187).
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <tuple>
#include <vector>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/force/annotate.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/jacobian/differences.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The columns of an n×n pattern, by colour. A template, so that programs without patterns don't compile it.
template <class Pattern = ColumnPattern>
class ColumnColoring {
 public:
  ColumnColoring() = default;
  /// @throws std::invalid_argument where the pattern isn't one of an n×n matrix
  ColumnColoring(const Pattern& pattern, Eigen::Index n) {
    pattern.check(n);
    const Pattern rows = transposed(pattern);
    std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    const Colors natural = greedy(pattern, rows, order);
    std::vector<Eigen::Index> neighbors(order.size(), 0);  // an upper bound: a neighbour by two rows counts twice
    for (const Eigen::Index j : order)
      for (const Eigen::Index i : pattern.rows(j)) neighbors[at(j)] += std::ssize(rows.rows(i));
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return neighbors[at(a)] > neighbors[at(b)]; });
    const Colors largest_first = greedy(pattern, rows, order);
    const Colors& colors = largest_first.count < natural.count ? largest_first : natural;
    columns_.resize(colors.count);
    for (Eigen::Index j = 0; j < n; ++j) columns_[colors.of[at(j)]].push_back(j);
  }

  [[nodiscard]] Eigen::Index colors() const { return std::ssize(columns_); }
  /// The columns of one colour, ascending.
  [[nodiscard]] const auto& columns(Eigen::Index color) const { return columns_[at(color)]; }

 private:
  struct Colors {
    std::vector<std::size_t> of;
    std::size_t count = 0;
  };
  [[nodiscard]] static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

  /// Which columns each row has.
  [[nodiscard]] static Pattern transposed(const Pattern& pattern) {
    Pattern rows{std::vector<Eigen::Index>(pattern.start.size(), 0), std::vector<Eigen::Index>(pattern.row.size())};
    for (const Eigen::Index i : pattern.row) ++rows.start[at(i) + 1];
    std::partial_sum(rows.start.begin(), rows.start.end(), rows.start.begin());
    std::vector<Eigen::Index> next(rows.start.begin(), rows.start.end() - 1);
    for (Eigen::Index j = 0; j < pattern.columns(); ++j)
      for (const Eigen::Index i : pattern.rows(j)) rows.row[at(next[at(i)]++)] = j;
    return rows;
  }
  [[nodiscard]] static Colors greedy(const Pattern& pattern, const Pattern& rows,
                                     const std::vector<Eigen::Index>& order) {
    const std::size_t none = order.size();
    Colors colors{std::vector<std::size_t>(order.size(), none)};
    std::vector<Eigen::Index> taken(order.size(), -1);  // by colour: the last column that may not have it
    for (const Eigen::Index j : order) {
      for (const Eigen::Index i : pattern.rows(j))
        for (const Eigen::Index other : rows.rows(i))
          if (const std::size_t c = colors.of[at(other)]; c != none) taken[c] = j;
      std::size_t c = 0;
      while (taken[c] == j) ++c;
      colors.of[at(j)] = c;
      colors.count = std::max(colors.count, c + 1);
    }
    return colors;
  }

  std::vector<std::vector<Eigen::Index>> columns_;  // by colour
};

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
    for (Unknown* x : {&rounding_, &increment_, &change_}) x->setZero(unknowns<S>(y));
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
    if (looks_ = !Rhs::Traits::is_affine && allowed.usual != nullptr; looks_) look_at_rounding(rhs, t, Y, psi);
    if constexpr (has_K) {
      std::array<Scalar, Rhs::blocks> scale{};
      // The tolerance is one for the unknowns, v: r may be off by what v's error moves it.
      const double time = std::abs(static_cast<double>(gamma.drift));
      const double kicked = largest_kick(gamma.force, std::get<0>(Rate::blocks(psi)), std::get<0>(rhs.masses()));
      scale[0] =
          scale_of(position_of<S>(Y), time * largest(velocity_of<S>(Y)), time * kicked, options, time * options.atol);
      const auto entry = [&system](Index i, Index j, Scalar x) { system.position(i, j, x); };
      const auto position = [](auto& y) -> auto& { return position_of<S>(y); };
      const auto scales = [&](auto k, Index i) { return size_of(allowed, position, i, scale[k]); };
      difference(rhs, t, std::tie(position_of<S>(probe_)), std::tie(position_of<S>(Y)), scales, scale, psi, entry);
    }
    if constexpr (has_C) {
      std::array<Scalar, Rhs::blocks> scale{};
      for_each_block(
          [&](auto k, const auto& block, const auto& rate, const auto& mass) {
            double fallback = 0;
            if constexpr (Rhs::drifts && k == 0)
              if (gamma.drift != Scalar{0})
                fallback = largest(position_of<S>(Y)) / std::abs(static_cast<double>(gamma.drift));
            const double kicked = std::min(largest_kick(gamma.force, rate, mass), kick_limit_[k]);
            kick_used_[k] = kicked;
            scale[k] = scale_of(block, kicked, fallback, options, options.atol);
          },
          Blocks<S>::solved(Y), Rate::blocks(psi), rhs.masses());
      const auto entry = [&system](Index i, Index j, Scalar x) { system.velocity(i, j, x); };
      const auto scales = [&](auto k, Index i) -> Scalar {
        if (!(allowed.target > 0)) return scale[k];
        const auto block = [](auto& y) -> auto& { return std::get<decltype(k)::value>(Blocks<S>::solved(y)); };
        if (allowed.has_unsized && block(*allowed.weight).data()[i] == 0)  // no size yet: soon that of its kick
          if (const Scalar kick = std::abs(std::get<k()>(rhs.masses()).h_over_mass(gamma.force)(i) *
                                           std::get<k()>(Rate::blocks(psi)).data()[i]);
              kick > 0)
            return 16 * kick;
        return size_of(allowed, block, i, scale[k]);
      };
      difference(rhs, t, Blocks<S>::solved(probe_), Blocks<S>::solved(Y), scales, scale, psi, entry);
    }
  }

  /// A stiff force kicks far and moves little: differences over the kick then miss the tangent. True once per block and
  /// matrix that did so, with the next differences confined to what Y and δ say.
  [[nodiscard]] bool differences_reached_too_far(const Plain& Y, const Unknown& correction) {
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

  /// The usual size of a component where a controlled run knows it: |y| + atol/rtol, or what it usually is.
  /// @param block  that of a state where it is
  [[nodiscard]] static Scalar size_of(const SolveTolerance<Plain>& allowed, auto&& block, Index i, Scalar otherwise) {
    const Scalar w = allowed.target > 0 ? block(*allowed.weight).data()[i] : Scalar{0};
    if (!(w > 0)) return otherwise;
    return Scalar{16} *
           (allowed.usual != nullptr ? block(*allowed.usual).data()[i] : 1 / (static_cast<Scalar>(allowed.rtol) * w));
  }

  /// What rounding of Y makes of Ψ, where sizes are the components' own: a small one's differences may drown in it.
  void look_at_rounding(Rhs& rhs, Scalar t, const Plain& Y, const Rate& psi) {
    for_each_number(
        [](std::size_t i, Scalar& x) { x *= 1 + (i % 2 == 0 ? 2 : -3) * std::numeric_limits<Scalar>::epsilon(); },
        Blocks<S>::all(probe_));
    rhs.evaluate_into(t, probe_, probe_rate_);
    for_each_rate(psi, [this](Index i, Scalar now, Scalar before) {
      rounding_[i] = std::max(std::abs(now - before), std::numeric_limits<Scalar>::epsilon() * std::abs(before));
    });
    copy_blocks<S>(probe_, Y);
  }
  /// How much farther a component should move, at most to `most`, for a change of Ψ to show. @param seen  the largest of its
  /// changes, each in units of rounding; 0: Ψ doesn't depend on it
  [[nodiscard]] static Scalar farther(Scalar seen, Scalar increment, Scalar most) {
    constexpr Scalar enough{1e6};
    if (!(seen > 0) || seen >= enough) return Scalar{1};
    return std::max(Scalar{1}, std::min(enough / seen, most / std::abs(increment)));
  }
  /// Differences over the components of `moved`, which are blocks of the probe and equal `still`; each entry to put.
  /// @param scales, scale  scales(k, i) of a component; scale[k] of a block's usual ones
  void difference(Rhs& rhs, Scalar t, const auto& moved, const auto& still, const auto& scales, const auto& scale,
                  const Rate& psi, auto&& put) {
    const auto most = [&scale](auto k) { return std::sqrt(std::numeric_limits<Scalar>::epsilon()) * scale[k]; };
    const auto evaluate = [&] {
      rhs.evaluate_into(t, probe_, probe_rate_);
      for_each_rate(psi, [this](Index i, Scalar now, Scalar before) { change_[i] = now - before; });
    };
    const auto put_back = [&](auto k, Index, Index i) { std::get<k>(moved).data()[i] = std::get<k>(still).data()[i]; };
    for (Index color = 0, all = colors(moved); color < all; ++color) {
      bool any = false;
      for_each_moved(color, moved, [&](auto k, Index j, Index i) {
        increment_[j] = move_by_increment<Rhs::Traits::is_affine>(std::get<k>(moved).data()[i], scales(k, i));
        any = true;
      });
      if (!any) continue;  // this colour has no column here
      evaluate();
      bool again = false;
      if (looks_)
        for_each_moved(color, moved, [&](auto k, Index j, Index) {
          Scalar seen{0};
          for_each_row(j, [&](Index i) { seen = std::max(seen, in_roundings(change_[i], i)); });
          const Scalar by = farther(seen, increment_[j], most(k));
          increment_[j] *= by;
          again = again || by > 1;
        });
      if (again) {
        for_each_moved(color, moved, put_back);
        for_each_moved(color, moved, [&](auto k, Index j, Index i) {
          Scalar& x = std::get<k>(moved).data()[i];
          const Scalar kept = x;
          x += increment_[j];
          increment_[j] = x - kept;
        });
        evaluate();
      }
      for_each_moved(color, moved, [&](auto, Index j, Index) {
        for_each_row(j, [&](Index i) { put(i, j, change_[i] / increment_[j]); });
      });
      for_each_moved(color, moved, put_back);
    }
  }
  /// A change of Ψ_i in units of what rounding makes of it.
  [[nodiscard]] Scalar in_roundings(Scalar change, Index i) const {
    if (change == 0) return Scalar{0};
    return rounding_[i] > 0 ? std::abs(change) / rounding_[i] : std::numeric_limits<Scalar>::infinity();
  }
  /// f(i, Ψ_i of the probe, Ψ_i of psi)
  void for_each_rate(const Rate& psi, auto&& f) const {
    for_each_number([&f](std::size_t i, Scalar now, Scalar before) { f(static_cast<Index>(i), now, before); },
                    Rate::blocks(probe_rate_), Rate::blocks(psi));
  }
  /// How many colours there are for these blocks: without a pattern each column has its own, and all rows.
  [[nodiscard]] Index colors(const auto& blocks) const {
    if constexpr (patterned) return columns_.coloring.colors();
    else return count_of(blocks);
  }
  /// f(block, column, component of the block) for a colour's columns that lie in the blocks.
  void for_each_moved(Index color, const auto& blocks, auto&& f) const {
    const auto& columns = [&]() -> decltype(auto) {
      if constexpr (patterned) return columns_.coloring.columns(color);
      else return std::array{color};
    }();
    Index at = 0;
    for_each_block(
        [&](auto k, auto& block) {
          for (const Index j : columns)
            if (at <= j && j < at + block.size()) f(k, j, j - at);
          at += block.size();
        },
        blocks);
  }
  /// f(i) for the rows of a column.
  void for_each_row(Index j, auto&& f) const {
    if constexpr (patterned) {
      for (const Index i : columns_.pattern.rows(j)) f(i);
    } else {
      for (Index i = 0; i < change_.size(); ++i) f(i);
    }
  }

  /// The force's pattern.
  struct Columns {
    ColumnPattern pattern;
    ColumnColoring<> coloring;
    bool fresh = false;

    void resize(Rhs& rhs, Index n) {
      const ColumnPattern& now = pattern_of_tangents(rhs.force(), n);
      if (coloring.colors() == 0 || now.start != pattern.start || now.row != pattern.row) {
        coloring = ColumnColoring<>(now, n);
        pattern = now;
      }
      fresh = true;
    }
  };

  Plain probe_;
  Rate probe_rate_;
  Unknown rounding_, increment_, change_;  // of Ψ; of y_j; of Ψ by moving y_j
  bool looks_ = false;
  [[no_unique_address]] Only<patterned, Columns> columns_;
  std::array<double, Rhs::blocks> kick_used_{}, kick_limit_{};  // how far differences reached, and may reach
};

}}  // namespace phistep::PHISTEP_ABI
