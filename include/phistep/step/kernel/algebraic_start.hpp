/// @file
/// Whether a step of M y' = Ψ with a singular M starts where the algebraic equations hold. With P Ψ for what is no M y', and
/// W = M − γJ the step's own matrix, the inconsistency moves the step by
///
///     x = W⁻¹ γ P Ψ(t, y),                                                                                      (1)
///
/// nothing where y is consistent, and for γ → 0 Newton's correction of the algebraic components at the differential ones
/// given. It has to be within the tolerance of a controlled run, else within 1e-6 of the largest component of its block.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/step/mass/bound_masses.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Asked once for each start and each state that was edited: it remembers both ends of the last step.
template <State S, class Rhs>
class AlgebraicStart {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;

  /// Takes another M. @return whether it is singular
  bool bind(const Rhs& rhs, const Plain& y) {
    has_any_ = static_cast<bool>(algebraic_component(rhs.masses()));
    forget();
    if (!has_any_) return false;
    response_ = y;
    residual_ = make_rate<S>(y);
    for (Known& each : known_) each.y = y;
    return true;
  }
  void forget() {
    for (Known& each : known_) each.t.reset();
  }

  /// Whether the state at t is another than those which the last step led from and to.
  [[nodiscard]] bool is_due(Scalar t, Scalar dt, const Plain& y) {
    if (!has_any_) return false;
    // A run's clock rounds otherwise than t + Δt.
    const Scalar rounding = 16 * std::numeric_limits<Scalar>::epsilon() * (std::abs(t) + std::abs(dt));
    for (std::size_t k = 0; k < known_.size(); ++k)
      if (known_[k].t && std::abs(t - *known_[k].t) <= rounding && equal_blocks<S>(y, known_[k].y))
        return start_ = k, false;
    return true;
  }
  /// The state at the end of a step, which serves as the next start.
  void reached(Scalar t, const auto& y) {
    if (has_any_) set(1 - start_, t, y);
  }
  /// Whether the step can begin, Ψ being step.psi.
  /// @param weight   of a controlled run, else null
  /// @param size     (x) → ‖x‖ in units of its tolerance, else null
  /// @param respond  (P Ψ, x) → Outcome: x = (1)
  [[nodiscard]] Outcome check(Rhs& rhs, const auto& step, const Plain* weight, auto&& size, auto&& respond) {
    if (first_non_finite(Rate::blocks(step.psi))) return Outcome::non_finite_force;
    if (leaves_residual(rhs, step.psi)) {
      if (const Outcome bad = respond(residual_, response_); failed(bad)) return bad;
      keep_unseen(Blocks<S>::solved(response_), rhs.masses());  // the rest follows from it, and may have no size yet
      bool is_allowed = false;
      if constexpr (requires { size(response_); }) is_allowed = size(response_) <= 1;
      else is_allowed = is_small(step.y);
      if (!is_allowed && !starts_from_nothing(rhs, step)) {
        find_worst(step.y, weight);
        return Outcome::inconsistent_start;
      }
    }
    set(start_ = 0, step.t, step.y);
    return Outcome::success;
  }
  /// The component of a refused start that (1) moves most, by its weight or beside its block.
  [[nodiscard]] const ComponentLocation& worst() const { return worst_; }

  /// The slope at a step's start is M⁻¹Ψ: it lacks the components that M doesn't see.
  void start_by_force() { lacks_start_ = has_any_; }
  /// Adds those components: the slope at the start of the parabola through both ends, with the slope at the second.
  void complete_start(const Rhs& rhs, auto& step) {
    if (!std::exchange(lacks_start_, false)) return;
    const auto y = in<S>(step.y), next = in<S>(step.next), end = in<S>(step.trace.end);
    assign<S>(response_, (2 / step.dt) * (next - y) - end);
    keep_unseen(Blocks<S>::solved(response_), rhs.masses());
    add<S>(step.trace.start, in<S>(response_));
  }
  /// f(x) at a step's end, where Ψ is psi: (1) of the components that M doesn't see, 0 of the others.
  [[nodiscard]] Outcome look_at_end(const Rhs& rhs, const Rate& psi, auto&& respond, auto&& f) {
    if (!has_any_ || !leaves_residual(rhs, psi)) return Outcome::success;
    if (const Outcome bad = respond(residual_, response_); failed(bad)) return bad;
    keep_unseen(Blocks<S>::solved(response_), rhs.masses());
    f(response_);
    return Outcome::success;
  }

 private:
  /// residual = P Ψ. False where there is nothing left.
  [[nodiscard]] bool leaves_residual(const Rhs& rhs, const Rate& psi) {
    residual_ = psi;
    keep_unexplained(Rate::blocks(residual_), rhs.masses());
    bool any = false;
    for_each_number([&any](auto, Scalar x) { any = any || x != 0; }, Rate::blocks(residual_));
    return any;
  }
  /// A step that may start at a jump asks Ψ six roundings after its start T (step/equation/origin.hpp). Where P Ψ is zero at T
  /// and grows, it isn't zero there, and beside a state of zeros that counts as inconsistent. What grows from zero has more than
  /// doubled at five times the distance from T; after a jump it hasn't.
  [[nodiscard]] bool starts_from_nothing(Rhs& rhs, const auto& step) const {
    const Scalar off = rhs.inside(step.t) - step.t;
    if (FieldState<S> || off == 0) return false;  // of a field, a rank sees its part alone
    Rate later = make_rate<S>(step.y);
    rhs.evaluate_into(step.t + 5 * off, step.y, later);
    keep_unexplained(Rate::blocks(later), rhs.masses());
    bool grows = true;
    for_each_number([&grows](auto, Scalar a, Scalar b) { grows = grows && 2 * std::abs(a) <= std::abs(b); },
                    Rate::blocks(residual_), Rate::blocks(later));
    return grows;
  }
  /// Whether the response (1) is small beside y, to a millionth of each block.
  [[nodiscard]] bool is_small(const Plain& y) const {
    bool all_small = true;
    for_each_block(
        [&](auto, const auto& x, const auto& of) { all_small = all_small && largest(x) <= 1e-6 * largest(of); },
        Blocks<S>::solved(response_), Blocks<S>::solved(y));
    return all_small;
  }
  void find_worst(const Plain& y, const Plain* weight) {
    worst_ = {};
    double most = -1;
    for_each_block(
        [&](auto k, const auto& x, const auto& of, const auto& w) {
          for (Index i = 0; i < x.size(); ++i) {
            const double moved = std::abs(static_cast<double>(x.data()[i])),
                         size = weight != nullptr ? moved * static_cast<double>(w.data()[i])
                                                  : moved / at_least_normal<Scalar>(largest(of));
            if (size > most) most = size, worst_.block = k, worst_.index = i;
          }
        },
        Blocks<S>::solved(response_), Blocks<S>::solved(y), Blocks<S>::solved(weight != nullptr ? *weight : y));
  }

  struct Known {
    std::optional<Scalar> t;
    Plain y;
  };
  void set(std::size_t k, Scalar t, const auto& y) {
    known_[k].t = t;
    copy_blocks<S>(known_[k].y, y);
  }

  Rate residual_;   // P Ψ
  Plain response_;  // (1)
  std::array<Known, 2> known_;
  ComponentLocation worst_;
  std::size_t start_ = 0;
  bool has_any_ = false, lacks_start_ = false;
};

/// In place of it where M is regular by its type.
struct RegularStart {
  static bool bind(const auto&...) { return false; }
  static void forget() {}
  static void reached(const auto&...) {}
  static void start_by_force() {}
  static void complete_start(const auto&...) {}
  [[nodiscard]] static Outcome look_at_end(const auto&...) { return Outcome::success; }
};

}}  // namespace phistep::PHISTEP_ABI
