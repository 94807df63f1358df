/// @file
/// Whether a step of M y' = Ψ with a singular M starts where the algebraic equations hold. With P Ψ for what is no M y', and
/// W = M − γJ the step's own matrix, the inconsistency moves the step by
///
///     x = W⁻¹ γ P Ψ(t, y),                                                                                      (1)
///
/// nothing where y is consistent, and for γ → 0 Newton's correction of the algebraic components at the differential ones
/// given. It has to be within the tolerance of a controlled run, else within 1e-6 of the largest component of its block.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "phistep/core/arithmetic.hpp"
#include "phistep/core/version.hpp"
#include "phistep/equation/bound_masses.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/non_finite.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Asked once for each start and each state that was edited: it remembers both ends of the last step.
template <State S, class Rhs>
class AlgebraicStart {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  bool lacks_start = false;  ///< the trace's slope at the start lacks what M doesn't see

  /// M may be another one.
  void bind(const Rhs& rhs, const Plain& y) {
    has_any_ = static_cast<bool>(algebraic_component(rhs.masses()));
    forget();
    if (!has_any_) return;
    response = y;
    residual = make_rate<S>(y);
    for (Known& each : known_) each.y = y;
  }
  [[nodiscard]] bool has_any() const { return has_any_; }
  void forget() {
    for (Known& each : known_) each.is = false;
  }

  /// Whether the state at t is another than those which the last step led from and to.
  [[nodiscard]] bool is_due(Scalar t, Scalar dt, const Plain& y) {
    // A run's clock rounds otherwise than t + Δt.
    const Scalar rounding = 16 * std::numeric_limits<Scalar>::epsilon() * (std::abs(t) + std::abs(dt));
    for (std::size_t k = 0; k < known_.size(); ++k)
      if (known_[k].is && std::abs(t - known_[k].t) <= rounding && equal_blocks<S>(y, known_[k].y))
        return start_ = k, false;
    return true;
  }
  /// It is consistent …
  void passed(Scalar t, const Plain& y) { set(start_ = 0, t, y); }
  /// … or a step's end.
  void reached(Scalar t, const auto& y) { set(1 - start_, t, y); }

  /// residual = P Ψ. False where there is nothing left.
  [[nodiscard]] bool leaves_residual(const Rhs& rhs, const Rate& psi) {
    copy_rate(residual, psi);
    keep_unexplained(Rate::blocks(residual), rhs.masses());
    bool any = false;
    for_each_number([&any](auto, Scalar x) { any = any || x != 0; }, Rate::blocks(residual));
    return any;
  }
  /// Whether the response (1) is small beside y, to a millionth of each block.
  [[nodiscard]] bool is_small(const Plain& y) const {
    bool all_small = true;
    for_each_block(
        [&](auto, const auto& x, const auto& of) { all_small = all_small && largest(x) <= 1e-6 * largest(of); },
        Blocks<S>::solved(response), Blocks<S>::solved(y));
    return all_small;
  }
  /// The component that (1) moves most, by its weight or beside its block.
  [[nodiscard]] Offender worst(const Plain& y, const Plain* weight) const {
    Offender found;
    double most = -1;
    for_each_block(
        [&](auto k, const auto& x, const auto& of, const auto& w) {
          for (Index i = 0; i < x.size(); ++i) {
            const double moved = std::abs(static_cast<double>(x.data()[i])),
                         size = weight != nullptr ? moved * static_cast<double>(w.data()[i])
                                                  : moved / at_least_normal<Scalar>(largest(of));
            if (size > most) most = size, found.block = k, found.index = i;
          }
        },
        Blocks<S>::solved(response), Blocks<S>::solved(y), Blocks<S>::solved(weight != nullptr ? *weight : y));
    return found;
  }

  Rate residual;   ///< P Ψ
  Plain response;  ///< (1)

 private:
  struct Known {
    bool is = false;
    Scalar t{};
    Plain y;
  };
  void set(std::size_t k, Scalar t, const auto& y) {
    known_[k].is = true;
    known_[k].t = t;
    copy_blocks<S>(known_[k].y, y);
  }

  std::array<Known, 2> known_;
  std::size_t start_ = 0;
  bool has_any_ = false;
};

}  // namespace phistep::inline PHISTEP_ABI
