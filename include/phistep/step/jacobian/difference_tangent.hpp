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
    rounding_.setZero(unknowns<S>(y));
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
      const double kicked = kick_of(gamma, std::get<0>(Rate::blocks(psi)), std::get<0>(rhs.masses()));
      scale[0] =
          scale_of(position_of<S>(Y), time * largest(velocity_of<S>(Y)), time * kicked, options, time * options.atol);
      const auto entry = [&system](Index i, Index j, Scalar x) { system.position(i, j, x); };
      const auto scales = [&](auto k, Index i) {
        return allowed.target > 0 ? told(
                                        allowed, [](auto& y) -> auto& { return position_of<S>(y); }, i, scale[k])
                                  : scale[k];
      };
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
            const double kicked = std::min(kick_of(gamma, rate, mass), kick_limit_[k]);
            kick_used_[k] = kicked;
            scale[k] = scale_of(block, kicked, fallback, options, options.atol);
          },
          Blocks<S>::solved(Y), Rate::blocks(psi), rhs.masses());
      const auto entry = [&system](Index i, Index j, Scalar x) { system.velocity(i, j, x); };
      const auto scales = [&](auto k, Index i) -> Scalar {
        if (!(allowed.target > 0)) return scale[k];
        const auto block = [](auto& y) -> auto& { return std::get<decltype(k)::value>(Blocks<S>::solved(y)); };
        if (allowed.has_unsized && block(*allowed.weight).data()[i] == 0)  // it is about to be as large as this
          if (const Scalar kick = std::abs(std::get<k()>(rhs.masses()).scaled(gamma.force)(i) *
                                           std::get<k()>(Rate::blocks(psi)).data()[i]);
              kick > 0)
            return 16 * kick;
        return told(allowed, block, i, scale[k]);
      };
      difference(rhs, t, Blocks<S>::solved(probe_), Blocks<S>::solved(Y), scales, scale, psi, entry);
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

  /// … of a component, where a controlled run says it: |y| + atol/rtol, or what it usually is.
  /// @param block  that of a state where it is
  [[nodiscard]] static Scalar told(const SolveTolerance<Plain>& allowed, auto&& block, Index i, Scalar otherwise) {
    const Scalar w = block(*allowed.weight).data()[i];
    if (!(w > 0)) return otherwise;
    return Scalar{16} *
           (allowed.usual != nullptr ? block(*allowed.usual).data()[i] : 1 / (static_cast<Scalar>(allowed.rtol) * w));
  }
  /// How far γΨ/M kicks a block, its farthest component.
  [[nodiscard]] static double kick_of(const Gamma<Scalar>& gamma, const auto& rate, const auto& mass) {
    double kicked = 0;
    const auto factor = mass.scaled(gamma.force);
    for (Index i = 0; i < rate.size(); ++i)
      kicked = std::max(kicked, std::abs(static_cast<double>(factor(i) * rate.data()[i])));
    return kicked;
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
  /// @param scale, scales  of a component; of a block's usual ones
  void difference(Rhs& rhs, Scalar t, const auto& moved, const auto& still, const auto& scale, const auto& scales,
                  const Rate& psi, auto&& put) {
    const auto most = [&scales](auto k) { return std::sqrt(std::numeric_limits<Scalar>::epsilon()) * scales[k]; };
    if constexpr (patterned) {
      const auto evaluate = [&] {
        rhs.evaluate_into(t, probe_, probe_rate_);
        for_each_rate(psi, [this](Index i, Scalar now, Scalar before) { columns_.change[i] = now - before; });
      };
      for (Index color = 0; color < columns_.coloring.colors(); ++color) {
        if (!move(color, moved, scale)) continue;
        evaluate();
        bool again = false;
        if (looks_)
          for_each_moved(color, moved, [&](auto k, Index j, Index) {
            Scalar seen{0};
            columns_.for_each_row(j, [&](Index i) { seen = std::max(seen, in_roundings(columns_.change[i], i)); });
            const Scalar by = farther(seen, columns_.increment[j], most(k));
            columns_.increment[j] *= by;
            again = again || by > 1;
          });
        if (again) {
          for_each_block([](auto, auto& to, const auto& from) { to = from; }, moved, still);
          for_each_moved(color, moved, [&](auto k, Index j, Index i) {
            Scalar& x = std::get<k>(moved).data()[i];
            const Scalar kept = x;
            x += columns_.increment[j];
            columns_.increment[j] = x - kept;
          });
          evaluate();
        }
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
                  if (looks_) {
                    Scalar seen{0};
                    for_each_rate(psi, [&](Index i, Scalar now, Scalar before) {
                      seen = std::max(seen, in_roundings(now - before, i));
                    });
                    if (const Scalar by = farther(seen, increment, most(k)); by > 1) {
                      Scalar& x = block.data()[j];
                      const Scalar kept = x - increment;
                      x = kept + by * increment;
                      increment = x - kept;
                      rhs.evaluate_into(t, probe_, probe_rate_);
                    }
                  }
                  for_each_rate(
                      psi, [&](Index i, Scalar now, Scalar before) { put(i, at + j, (now - before) / increment); });
                });
            at += block.size();
          },
          moved);
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
  Unknown rounding_;  // of Ψ
  bool looks_ = false;
  [[no_unique_address]] Only<patterned, Columns> columns_;
  std::array<double, Rhs::blocks> kick_used_{}, kick_limit_{};  // how far differences reached, and may reach
};

}}  // namespace phistep::PHISTEP_ABI
