/// @file
/// K = ∂Ψ/∂r and C = ∂Ψ/∂v (or ∂Ψ/∂y) of a bound force by differences, with increments scaled by what a step moves.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "phistep/core/version.hpp"
#include "phistep/jacobian/differences.hpp"
#include "phistep/resolve/newton.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"
#include "phistep/stepper/right_hand_side.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The coefficients of a resolve: γ on the force and γ on the drift. [time]
template <class Scalar>
struct Gamma {
  Scalar force;
  Scalar drift;
  friend bool operator==(const Gamma&, const Gamma&) = default;
};

template <State S, class Rhs, bool has_K, bool has_C>
class DifferenceTangent {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Unknown = Eigen::Matrix<Scalar, static_unknowns<S>, 1>;

  void resize(const Plain& y) {
    probe_ = y;
    probe_rate_ = make_rate<S>(y);
  }
  /// A new solve: nothing is known of how far it moves.
  void begin() { kick_limit_.fill(std::numeric_limits<double>::infinity()); }

  /// Puts K and C at (t, Y), where Ψ is psi, into the system.
  void compute(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, const Plain& Y, const Rate& psi,
               const NewtonOptions& options, auto& system) {
    copy_blocks<S>(probe_, Y);
    const auto column = [&](Index j, Scalar delta, auto&& put) {
      rhs.evaluate_into(t, probe_, probe_rate_);
      Index at = 0;
      for_each_block(
          [&](auto, const auto& moved, const auto& still) {
            for (Index i = 0; i < still.size(); ++i) put(at + i, j, (moved.data()[i] - still.data()[i]) / delta);
            at += still.size();
          },
          Rate::blocks(probe_rate_), Rate::blocks(psi));
    };
    double moved_by_drift = 0;
    if constexpr (Rhs::drifts) moved_by_drift = std::abs(static_cast<double>(gamma.drift)) * largest(velocity_of<S>(Y));
    if constexpr (has_K)
      for_each_difference<Rhs::Traits::is_affine>(
          position_of<S>(probe_), scale_of(position_of<S>(Y), moved_by_drift, 0, options), [&](Index j, Scalar delta) {
            column(j, delta, [&system](Index i, Index k, Scalar x) { system.position(i, k, x); });
          });
    if constexpr (has_C) {
      Index at = 0;
      for_each_block(
          [&](auto k, auto& block, const auto& rate, const auto& mass) {
            double fallback = 0;
            if constexpr (Rhs::drifts && k == 0)
              if (gamma.drift != Scalar{0})
                fallback = largest(position_of<S>(Y)) / std::abs(static_cast<double>(gamma.drift));
            double kicked = 0;
            const auto factor = mass.scaled(gamma.force);
            for (Index i = 0; i < rate.size(); ++i)
              kicked = std::max(kicked, std::abs(static_cast<double>(factor(i) * rate.data()[i])));
            kicked = std::min(kicked, kick_limit_[k]);
            kick_used_[k] = kicked;
            for_each_difference<Rhs::Traits::is_affine>(
                block, scale_of(block, kicked, fallback, options), [&](Index j, Scalar delta) {
                  column(at + j, delta, [&system](Index i, Index c, Scalar x) { system.velocity(i, c, x); });
                });
            at += block.size();
          },
          Blocks<S>::solved(probe_), Rate::blocks(psi), rhs.masses());
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
  [[nodiscard]] static Scalar scale_of(const auto& block, double moved, double fallback, const NewtonOptions& options) {
    double scale = std::max(largest(block), moved);
    if (scale == 0) scale = fallback;
    if (options.rtol > 0) scale = 16 * options.atol / options.rtol;
    return static_cast<Scalar>(scale > 0 ? scale : 1.0);
  }

  Plain probe_;
  Rate probe_rate_;
  std::array<double, Rhs::blocks> kick_used_{}, kick_limit_{};  // how far differences reached, and may reach
};

}  // namespace phistep::inline PHISTEP_ABI
