/// @file
/// What a resolve iterates on: the increment w = Y − b of the solved blocks (n unknowns for a motion, not 2n), its
/// corrections δ and their sizes.
///
/// Digits. Y = b + w would lose what a strong decay cancels (Y ≪ b), and b + w is the exact thing to store where nothing
/// cancels. So each component decides for itself: where |b + w| < |b|/2 the iterate is corrected in place, Y ← Y + δ,
/// which refines itself; elsewhere Y = b + w. The same rule serves r, v following from it. It replaces a choice between
/// velocity, displacement and absolute unknowns by stiffness, and knows no units.
///
/// An affine force gets one correction and no second to refine it, so there the start decides: Y = start + δ, from
/// v = v_n, or from r = r_n (the displacement as unknown) where the drift's part of W is by far the larger. Either δ is then
/// small beside what it is added to.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>

#include "phistep/core/version.hpp"
#include "phistep/solve/newton.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Ψ(t, Y) = M w/γ_f of a resolve with the increment w: known without a force call.
template <State S>
void recover_force(const auto& rhs, const auto& w, ScalarOf<S> gamma_force, RateOf<S>& psi) {
  Index at = 0;
  for_each_block(
      [&](auto, auto& block, const auto& mass) {
        auto rate = flat(block);
        rate.setZero();
        mass.subtract_product(part(w, at, block), rate);
        rate *= ScalarOf<S>{-1} / gamma_force;
        at += block.size();
      },
      RateOf<S>::blocks(psi), rhs.masses());
}

template <State S>
class Increment {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Unknown = Eigen::Matrix<Scalar, static_unknowns<S>, 1>;
  static constexpr bool drifts = Blocks<S>::drifts;

  void resize(const Plain& y) {
    const Index n = unknowns<S>(y);
    base_ = y;
    w_.setZero(n);
    delta_.setZero(n);
    last_move_.setZero(n);
  }

  void set_base(const Plain& b) { copy_blocks<S>(base_, b); }
  [[nodiscard]] const Plain& base() const { return base_; }
  [[nodiscard]] const Unknown& w() const { return w_; }
  /// The residual before the linear solve, the correction after it.
  [[nodiscard]] Unknown& delta() { return delta_; }
  [[nodiscard]] const Unknown& delta() const { return delta_; }

  /// Y.solved = guess.solved; r follows from v.
  void start(Plain& Y, const Plain& guess, Scalar gamma_drift) {
    for_each_solved<S>(
        [this](Index at, auto& y, const auto& from, const auto& base) {
          part(w_, at, y) = flat(from) - flat(base);
          y = from;
        },
        Y, guess, base_);
    if constexpr (drifts) position_of<S>(Y) = position_of<S>(base_) + gamma_drift * velocity_of<S>(Y);
  }
  /// The same with Y.r = guess.r, v following from r.
  void start_at_position(Plain& Y, const Plain& guess, Scalar gamma_drift) requires drifts {
    start(Y, guess, gamma_drift);
    auto &r = position_of<S>(Y), &v = velocity_of<S>(Y);
    r = position_of<S>(guess);
    v = (r - position_of<S>(base_)) / gamma_drift;
    part(w_, 0, v) = flat(v) - flat(velocity_of<S>(base_));
  }

  /// Y ← Y + δ by the rule in the file's head.
  void move(Plain& Y, Scalar gamma_drift) {
    last_move_ = delta_;
    apply(Y, gamma_drift);
  }
  /// Y ← Y + δ as it stands: the only correction there is.
  void move_once(Plain& Y, Scalar gamma_drift, bool at_position) {
    w_ += delta_;
    for_each_solved<S>([this](Index at, auto& y) { flat(y) += part(delta_, at, y); }, Y);
    if constexpr (drifts) {
      auto &r = position_of<S>(Y), &v = velocity_of<S>(Y);
      if (at_position) flat(r) += gamma_drift * part(delta_, 0, v);
      else r = position_of<S>(base_) + gamma_drift * v;
    }
  }
  /// Takes back half of the last move.
  void retreat(Plain& Y, Scalar gamma_drift) {
    last_move_ *= Scalar{0.5};
    undo(Y, gamma_drift);
  }
  void undo(Plain& Y, Scalar gamma_drift) {
    delta_ = -last_move_;
    apply(Y, gamma_drift);
  }

  /// @param drift_share  the system's ‖γ_f γ_d K‖ / ‖W‖
  [[nodiscard]] Correction size(const Plain& Y, Scalar gamma_drift, double drift_share,
                                const NewtonOptions& options) const {
    if (options.rtol > 0) return weighted_size(Y, options);
    Correction worst;
    bool first = true;
    for_each_solved<S>(
        [&](Index at, const auto& y, const auto& base) {
          const double delta = largest(part(last_move_, at, y)), size = largest(y);
          double resolution = std::max(size, largest(base));
          // Rounding of r reaches δ through K alone: all of it where springs are stiff, nothing where there are none.
          if constexpr (drifts)
            if (first && gamma_drift != Scalar{0})
              resolution = std::max(
                  resolution, drift_share * largest(position_of<S>(Y)) / std::abs(static_cast<double>(gamma_drift)));
          first = false;
          worst.absolute = std::max(worst.absolute, delta);
          if (delta > 0) {
            worst.relative = std::max(worst.relative, relative_size<Scalar>(delta, size));
            worst.resolution = std::max(worst.resolution, relative_size<Scalar>(delta, resolution));
          }
        },
        Y, base_);
    return worst;
  }

  /// The same in the norm of a controlled run. @param weight  its solved blocks count
  [[nodiscard]] Correction weighted_size(const Plain& weight) const {
    Scalar sum{0};
    for_each_solved<S>(
        [&](Index at, const auto& w) { sum += flat(w).cwiseProduct(part(last_move_, at, w)).squaredNorm(); }, weight);
    const double norm = std::sqrt(static_cast<double>(sum) / std::max(1.0, static_cast<double>(last_move_.size())));
    return {norm, norm, norm};
  }

  /// out.solved += factor·w
  void add_to(Plain& out, Scalar factor) const {
    for_each_solved<S>([&](Index at, auto& y) { flat(y) += factor * part(w_, at, y); }, out);
  }

 private:
  void apply(Plain& Y, Scalar gamma_drift) {
    w_ += delta_;
    for_each_solved<S>(
        [this](Index at, auto& y, const auto& base) {
          for (Index i = 0; i < y.size(); ++i)
            y.data()[i] = refined(base.data()[i], w_[at + i], y.data()[i], delta_[at + i]);
        },
        Y, base_);
    if constexpr (drifts) {
      Scalar *const r = position_of<S>(Y).data(), *const v = velocity_of<S>(Y).data();
      const Scalar* const base = position_of<S>(base_).data();
      for (Index i = 0; i < position_of<S>(Y).size(); ++i) {
        const Scalar sum = base[i] + gamma_drift * v[i];
        if (std::abs(sum) < std::abs(base[i]) / 2) {
          r[i] += gamma_drift * delta_[i];
          v[i] = (r[i] - base[i]) / gamma_drift;  // no digits lost here: r is small beside its base
        } else {
          r[i] = sum;
        }
      }
    }
  }
  [[nodiscard]] static Scalar refined(Scalar base, Scalar increment, Scalar iterate, Scalar correction) {
    const Scalar sum = base + increment;
    return std::abs(sum) < std::abs(base) / 2 ? iterate + correction : sum;
  }

  [[nodiscard]] Correction weighted_size(const Plain& Y, const NewtonOptions& options) const {
    const double rtol = ConvergenceTest::reduced(options.rtol), atol = rtol * options.atol / options.rtol;
    constexpr auto least = static_cast<double>(std::numeric_limits<Scalar>::min());
    double sum = 0;
    for_each_solved<S>(
        [&](Index at, const auto& y, const auto& base) {
          for (Index i = 0; i < y.size(); ++i) {
            const double size = static_cast<double>(std::max(std::abs(y.data()[i]), std::abs(base.data()[i])));
            const double delta = static_cast<double>(last_move_[at + i]);
            if (delta != 0) sum += std::pow(delta / std::max(atol + rtol * size, least), 2);
          }
        },
        Y, base_);
    const double norm = std::sqrt(sum / std::max(1.0, static_cast<double>(last_move_.size())));
    return {norm, norm, largest(last_move_)};
  }

  Plain base_;
  Unknown w_, delta_, last_move_;
};

}  // namespace phistep::inline PHISTEP_ABI
