/// @file
/// What a resolve iterates on: the increment w = Y − b of the solved blocks (n unknowns for a motion, not 2n), its
/// corrections δ and their sizes.
///
/// Digits. Where a strong decay makes Y ≪ b, Y = b + w loses digits; where nothing cancels, b + w is exact. So each component
/// decides for itself: where |b + w| < |b|/2 the iterate is corrected in place, Y ← Y + δ, and later corrections refine it;
/// elsewhere Y = b + w. The same rule serves r, and where r is corrected in place, v follows from it. So no choice between
/// velocity, displacement and absolute unknowns by stiffness is needed, and no units.
///
/// An affine force gets one correction and no second to refine it, so there the start decides: Y = start + δ, from
/// v = v_n, or from r = r_n (the displacement as unknown) where the drift's part of W is by far the larger. Either δ is then
/// small beside what it is added to.
///
/// The library sees no number of a field: there Y = b + w in all components, and where w cancels b digits are lost.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/solve/convergence.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Ψ(t, Y) = M w/γ_f of a resolve with the increment w: known without a force call.
template <State S>
void recover_force(const auto& rhs, const auto& w, ScalarOf<S> gamma_force, RateOf<S>& psi) {
  for_each_part(
      [&](Index at, auto& block, const auto& mass) {
        auto&& rate = flat(block);
        rate.setZero();
        mass.subtract_product(part(w, at, block), rate);
        rate *= ScalarOf<S>{-1} / gamma_force;
      },
      RateOf<S>::blocks(psi), rhs.masses());
}

/// √(1/n Σ x_i²) of a field by this rank's part of the sum: one reduction.
template <FieldBlock Field>
[[nodiscard]] double rms_of_ranks(const Field& x, double mine) {
  Field::Ops::total(x.handle(), std::span<double>{&mine, 1});
  return std::sqrt(mine / std::max(1.0, static_cast<double>(x.size())));
}
/// √(1/n Σ (x_i w_i)²) of n unknowns, in a controlled run's weights; what has none yet is measured by Y.
/// @return that, and whether a component has just come to be
template <State S>
[[nodiscard]] std::pair<double, bool> rms_of_unknowns(const auto& x, const PlainState<S>& Y,
                                                      const SolveTolerance<PlainState<S>>& allowed) {
  using Scalar = ScalarOf<S>;
  if constexpr (FieldState<S>) {
    const auto& weight = std::get<0>(Blocks<S>::solved(*allowed.weight));
    return {rms_of_ranks(x, UnknownsOf<S>::type::Ops::square(x.handle(), weight.handle())), false};
  } else {
    Scalar sum{0};
    bool is_new = false;
    for_each_solved<S>([&](Index at, const auto& w) { sum += flat(w).cwiseProduct(part(x, at, w)).squaredNorm(); },
                       *allowed.weight);
    if (allowed.has_unsized)
      for_each_solved<S>(
          [&](Index at, const auto& w, const auto& y) {
            for (Index i = 0; i < w.size(); ++i) {
              if (w.data()[i] != 0 || x[at + i] == 0) continue;
              const Scalar of = std::abs(x[at + i]) / at_least_normal<Scalar>(std::abs(y.data()[i]));
              sum += of * of / static_cast<Scalar>(allowed.rtol * allowed.rtol);
              is_new = is_new || of == 1;
            }
          },
          *allowed.weight, Y);
    return {std::sqrt(static_cast<double>(sum) / std::max(1.0, static_cast<double>(x.size()))), is_new};
  }
}
/// The same in the weights of a solver with a tolerance of its own, 1/(atol + rtol max(|Y|, |b|)).
template <State S>
[[nodiscard]] double rms_of_unknowns(const auto& x, const PlainState<S>& Y, const auto& base, const auto& options) {
  using Scalar = ScalarOf<S>;
  const double rtol = solve_rtol(options.rtol), atol = rtol * options.atol / options.rtol;
  if constexpr (FieldState<S>) {
    const auto& end = std::get<0>(Blocks<S>::solved(Y));
    return rms_of_ranks(x, UnknownsOf<S>::type::Ops::square(x.handle(), end.handle(), base.handle(),
                                                            static_cast<Scalar>(atol), static_cast<Scalar>(rtol)));
  } else {
    double sum = 0;
    for_each_solved<S>(
        [&](Index at, const auto& y) {
          for (Index i = 0; i < y.size(); ++i) {
            const double size = static_cast<double>(std::max(std::abs(y.data()[i]), std::abs(base[at + i])));
            const double of = static_cast<double>(x[at + i]);
            if (of != 0) sum += std::pow(of / at_least_normal<Scalar>(atol + rtol * size), 2);
          }
        },
        Y);
    return std::sqrt(sum / std::max(1.0, static_cast<double>(x.size())));
  }
}

template <State S>
class Increment {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Unknown = typename UnknownsOf<S>::type;
  static constexpr bool drifts = Blocks<S>::drifts;

  Unknown base;   ///< b
  Unknown w;      ///< Y − b
  Unknown delta;  ///< the residual before the linear solve, the correction after it

  void resize(const Plain& y) {
    for (Unknown* x : {&base, &w, &delta, &last_move_}) {
      if constexpr (FieldState<S>) set_zero_like(*x, std::get<0>(Blocks<S>::solved(y)));
      else x->setZero(unknowns<S>(y));
    }
    if constexpr (!in_one_piece) gathered_ = base;
    if constexpr (drifts) base_r_ = flat(position_of<S>(y));
  }

  /// b, and γ_d of a motion, whose r is b.r + γ_d v.
  void begin(const Plain& b, Scalar gamma_drift) {
    take_unknowns<S>(base, b);
    if constexpr (drifts) base_r_ = flat(position_of<S>(b));
    gamma_drift_ = gamma_drift;
  }

  /// Y.solved = guess.solved; r follows from v.
  void start(Plain& Y, const Plain& guess) {
    auto&& x = iterate(Y);
    take_unknowns<S>(x, guess);
    w = x - base;
    drift(x, Y);
    put(Y);
  }
  /// The same with Y.r = guess.r, v following from r.
  void start_at_position(Plain& Y, const Plain& guess) requires drifts {
    auto&& x = iterate(Y);
    auto&& r = flat(position_of<S>(Y));
    take_unknowns<S>(x, guess);
    r = flat(position_of<S>(guess));
    part(x, 0, r) = (r - base_r_) / gamma_drift_;
    w = x - base;
    put(Y);
  }

  /// Y = b + w for this w.
  void place(Plain& Y) {
    auto&& x = iterate(Y);
    x = base + w;
    drift(x, Y);
    put(Y);
  }
  /// Y ← Y + δ by the rule in the file's head.
  void move(Plain& Y) {
    last_move_ = delta;
    apply(Y);
  }
  /// Y ← Y + δ as it stands: the only correction there is.
  void move_once(Plain& Y, bool at_position) {
    auto&& x = iterate(Y);
    w += delta;
    x += delta;
    if constexpr (drifts) {
      auto&& r = flat(position_of<S>(Y));
      if (at_position) r += gamma_drift_ * part(delta, 0, r);
      else drift(x, Y);
    }
    put(Y);
  }
  /// Takes back half of the last move.
  void retreat(Plain& Y) {
    last_move_ *= Scalar{0.5};
    undo(Y);
  }
  void undo(Plain& Y) {
    delta = -last_move_;
    apply(Y);
  }

  /// The size of the last move. @param drift_share  the system's ‖γ_f γ_d K‖ / ‖W‖
  [[nodiscard]] Correction size(const Plain& Y, double drift_share, const NewtonOptions& options) const {
    if (options.rtol > 0) {
      const double norm = rms_of_unknowns<S>(last_move_, Y, base, options);
      if constexpr (FieldState<S>) return {norm, norm, norm};
      else return {norm, norm, largest(last_move_)};
    }
    if constexpr (FieldState<S>) return size_of_field(Y);
    // Rounding of r reaches δ through K alone: all of it where springs are stiff, nothing where there are none. (r is counted with
    // the first block.)
    double rounding = drift_size(Y, drift_share);
    Correction worst;
    for_each_solved<S>(
        [&](Index at, const auto& y) {
          const double of = largest(part(last_move_, at, y)), size = largest(y);
          const double all = std::max(std::max(size, largest(part(base, at, y))), std::exchange(rounding, 0));
          worst.absolute = std::max(worst.absolute, of);
          if (of > 0) {
            worst.relative = std::max(worst.relative, relative_size<Scalar>(of, size));
            worst.beside_all = std::max(worst.beside_all, relative_size<Scalar>(of, all));
          }
        },
        Y);
    return worst;
  }
  /// The same in the norm of a controlled run.
  [[nodiscard]] Correction size(const Plain& Y, const SolveTolerance<Plain>& allowed) const {
    const auto [norm, is_new] = rms_of_unknowns<S>(last_move_, Y, allowed);
    return {norm, norm, norm, is_new};
  }
  /// ‖r‖/γ_d times the share of it that the solve sees, 0 where nothing drifts.
  [[nodiscard]] double drift_size(const Plain& Y, double drift_share) const {
    if constexpr (drifts && !FieldState<S>)
      if (gamma_drift_ != Scalar{0})
        return drift_share * largest(position_of<S>(Y)) / std::abs(static_cast<double>(gamma_drift_));
    return 0;
  }

 private:
  static constexpr bool in_one_piece = solved_blocks<S> == 1;
  /// The unknowns of Y where they lie, or, of several blocks, gathered: put() writes those back.
  [[nodiscard]] decltype(auto) iterate(Plain& Y) {
    if constexpr (in_one_piece) return flat(std::get<0>(Blocks<S>::solved(Y)));
    else return flat(gathered_);
  }
  void put(Plain& Y) const {
    if constexpr (!in_one_piece) put_unknowns<S>(gathered_, Y);
  }
  /// r = b.r + γ_d v
  void drift(const auto& x, Plain& Y) const {
    if constexpr (drifts) {
      auto&& r = flat(position_of<S>(Y));
      r = base_r_ + gamma_drift_ * part(x, 0, r);
    }
  }

  /// To rounding, by one reduction.
  [[nodiscard]] Correction size_of_field(const Plain& Y) const requires FieldState<S> {
    const auto here = [](const Unknown& x) { return static_cast<double>(Unknown::Ops::largest_here(x.handle())); };
    double all[] = {here(last_move_), here(std::get<0>(Blocks<S>::solved(Y))), here(base)};
    Unknown::Ops::greatest(base.handle(), all);
    const double of = all[0];
    if (of == 0) return {};
    return {relative_size<Scalar>(of, all[1]), relative_size<Scalar>(of, std::max(all[1], all[2])), of};
  }

  void apply(Plain& Y) {
    w += delta;
    if constexpr (FieldState<S>) place(Y);
    else apply_to_numbers(Y);
  }
  void apply_to_numbers(Plain& Y) {
    auto&& x = iterate(Y);
    for (Index i = 0; i < x.size(); ++i) {
      const Scalar sum = base[i] + w[i];
      x[i] = std::abs(sum) < std::abs(base[i]) / 2 ? x[i] + delta[i] : sum;
    }
    if constexpr (drifts) {
      auto&& r = flat(position_of<S>(Y));
      for (Index i = 0; i < r.size(); ++i) {
        const Scalar sum = base_r_[i] + gamma_drift_ * x[i];
        if (std::abs(sum) < std::abs(base_r_[i]) / 2) {
          r[i] += gamma_drift_ * delta[i];
          x[i] = (r[i] - base_r_[i]) / gamma_drift_;  // no digits lost here: r is small beside its base
        } else {
          r[i] = sum;
        }
      }
    }
    put(Y);
  }

  using Position = typename std::remove_cvref_t<decltype(flat(position_of<S>(std::declval<Plain&>())))>::PlainObject;
  Unknown last_move_;
  [[no_unique_address]] Only<drifts, Position> base_r_;
  [[no_unique_address]] Only<!in_one_piece, Unknown> gathered_;
  Scalar gamma_drift_{};
};

}}  // namespace phistep::PHISTEP_ABI
