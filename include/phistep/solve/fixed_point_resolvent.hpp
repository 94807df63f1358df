/// @file
/// M (Y − b) = γ_f Ψ(t, Y) by fixed-point iteration on w = Y − b: w ← γ_f M⁻¹Ψ(t, Y(w)). One force call an iteration and
/// nothing else.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

#include "phistep/core/arithmetic.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/version.hpp"
#include "phistep/jacobian/differences.hpp"
#include "phistep/simd/update.hpp"
#include "phistep/solve/fixed_point.hpp"
#include "phistep/solve/increment.hpp"
#include "phistep/solve/local_resolvent.hpp"
#include "phistep/solve/newton.hpp"
#include "phistep/solve/resolvent.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"

namespace phistep::inline PHISTEP_ABI {

template <State S, class Rhs>
class FixedPointResolvent {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Unknown = Eigen::Matrix<Scalar, static_unknowns<S>, 1>;

  FixedPointResolvent(const Plain& y, const Rhs& rhs, const FixedPoint& solver) : options_{solver.options} {
    resize(y, rhs);
  }
  void resize(const Plain& y, const Rhs&) {
    const Index n = unknowns<S>(y);
    base_ = y;
    increment_.setZero(n);
    image_.setZero(n);
    residual_.setZero(n);
    anderson_.resize(n, options_.depth);
  }
  static void forget() {}
  static void reset() {}

  /// In: Y = b; `guess` is where the iteration starts (its solved blocks count). Out: Y, and w = Y − b.
  [[nodiscard]] Outcome resolve(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, Plain& Y, const Plain& guess, Rate& psi,
                                Failure& history, bool psi_known = false, SolveTolerance<Plain> allowed = {}) {
    if (options_.rtol > 0) allowed.target = 0;
    using enum FixedPointTest::Verdict;
    copy_blocks<S>(base_, Y);
    for_each_solved<S>(
        [this](Index at, const auto& from, const auto& base) { part(increment_, at, from) = flat(from) - flat(base); },
        guess, base_);
    place(Y, gamma);
    anderson_.begin();
    FixedPointTest test(options_, static_cast<double>(std::numeric_limits<Scalar>::epsilon()), allowed.target);
    for (int k = 1;; ++k) {
      if (k > 1 || !psi_known) rhs.evaluate_into(t, Y, psi);
      map(rhs, gamma, psi);
      if (!all_finite(residual_.data(), residual_.size()))
        return first_non_finite(Rate::blocks(psi)) ? Outcome::non_finite_force : Outcome::non_finite_state;
      if (k == 1) weigh(Y, gamma);
      Correction size = this->size(Y);
      if (allowed.target > 0) size.relative = weighted_size(*allowed.weight);
      history.record(size.resolution);
      ++rhs.statistics().iterations;
      const auto verdict = test.judge(k, size, anderson_.stretches());
      if (verdict == diverged) return Outcome::iteration_diverged;
      if (verdict == stalled) return Outcome::iteration_stalled;
      if (verdict == converged) {
        if (anderson_.stretches()) return Outcome::success;
        increment_ = image_;
        place(Y, gamma);
        return Outcome::success;
      }
      anderson_.mix(increment_, residual_, image_, [this](const auto& a, const auto& b) { return this->inner(a, b); });
      place(Y, gamma);
    }
  }

  /// There is no matrix, and nothing stiff: the estimate stays what it is.
  [[nodiscard]] static Outcome filter(const Rhs&, const Plain&) { return Outcome::success; }

  [[nodiscard]] static bool keeps_factors() { return false; }
  [[nodiscard]] static const char* solver_name() { return "fixed-point iteration"; }

  /// out.solved += factor·(Y − b) with the last resolve's increment.
  void add_increment(Scalar factor, Plain& out) const {
    for_each_solved<S>([&](Index at, auto& y) { flat(y) += factor * part(increment_, at, y); }, out);
  }
  /// Ψ(t, Y) of the last resolve, without a force call.
  void recover(const Rhs& rhs, Scalar gamma_force, Rate& psi) const {
    recover_force<S>(rhs, increment_, gamma_force, psi);
  }

 private:
  /// Y = b + w, and r after v.
  void place(Plain& Y, const Gamma<Scalar>& gamma) const {
    for_each_solved<S>([this](Index at, auto& y, const auto& base) { flat(y) = flat(base) + part(increment_, at, y); },
                       Y, base_);
    if constexpr (Rhs::drifts) position_of<S>(Y) = position_of<S>(base_) + gamma.drift * velocity_of<S>(Y);
  }
  /// g = γ_f M⁻¹Ψ, f = g − w
  void map(const Rhs& rhs, const Gamma<Scalar>& gamma, const Rate& psi) {
    Index at = 0;
    for_each_block(
        [&](auto, const auto& block, const auto& mass) {
          auto image = part(image_, at, block);
          image = flat(block);
          if constexpr (std::remove_cvref_t<decltype(mass)>::is_matrix)
            if (all_finite(block.data(), block.size())) mass.solve(image);
          const auto factor = mass.scaled(gamma.force);
          for (Index i = 0; i < image.size(); ++i) image[i] *= factor(i);
          at += block.size();
        },
        Rate::blocks(psi), rhs.masses());
    residual_ = image_ - increment_;
  }
  /// Blocks may have different units: each is measured by a size of its own that stands still during a solve, so that the
  /// recorded increments fall as the iteration contracts. r/γ is there because its rounding reaches f through Ψ.
  void weigh(const Plain& Y, const Gamma<Scalar>& gamma) {
    std::size_t k = 0;
    for_each_solved<S>(
        [&](Index at, const auto& y, const auto& base) {
          double size = std::max({largest(y), largest(base), largest(part(residual_, at, y))});
          if constexpr (Rhs::drifts)
            if (k == 0 && gamma.drift != Scalar{0})
              size = std::max(size, largest(position_of<S>(base_)) / std::abs(static_cast<double>(gamma.drift)));
          // Of subnormal numbers the inverse would be infinite.
          size = size > 0 ? at_least_normal<Scalar>(size) : 1;
          int exponent = 0;
          std::frexp(size, &exponent);
          sizes_[k] = size;
          scale_[k++] = std::ldexp(Scalar{1}, -exponent);
        },
        Y, base_);
  }
  [[nodiscard]] Scalar inner(const auto& a, const auto& b) const {
    if constexpr (Rhs::blocks == 1) {
      return (scale_[0] * a).dot(scale_[0] * b);
    } else {
      Scalar sum{0};
      std::size_t k = 0;
      for_each_solved<S>(
          [&](Index at, const auto& y) {
            sum += (scale_[k] * a.segment(at, y.size())).dot(scale_[k] * b.segment(at, y.size()));
            ++k;
          },
          std::as_const(base_));
      return sum;
    }
  }

  /// ‖f‖ in the norm of a controlled run.
  [[nodiscard]] double weighted_size(const Plain& weight) const {
    Scalar sum{0};
    for_each_solved<S>(
        [&](Index at, const auto& w) { sum += flat(w).cwiseProduct(part(residual_, at, w)).squaredNorm(); }, weight);
    return std::sqrt(static_cast<double>(sum) / std::max(1.0, static_cast<double>(residual_.size())));
  }
  /// Of f, as of a correction: relative to Y, or in the weighted RMS norm.
  [[nodiscard]] Correction size(const Plain& Y) const {
    Correction worst;
    const double rtol = options_.rtol > 0 ? ConvergenceTest::reduced(options_.rtol) : 0;
    const double atol = options_.rtol > 0 ? rtol * options_.atol / options_.rtol : 0;
    double sum = 0;
    std::size_t k = 0;
    for_each_solved<S>(
        [&](Index at, const auto& y, const auto& base) {
          const double delta = largest(part(residual_, at, y)), size = largest(y);
          worst.absolute = std::max(worst.absolute, delta);
          worst.resolution = std::max(worst.resolution, delta / sizes_[k++]);
          if (delta > 0) worst.relative = std::max(worst.relative, relative_size<Scalar>(delta, size));
          if (rtol > 0)
            for (Index i = 0; i < y.size(); ++i) {
              const double of = static_cast<double>(std::max(std::abs(y.data()[i]), std::abs(base.data()[i])));
              const double f = static_cast<double>(residual_[at + i]);
              if (f != 0) sum += std::pow(f / at_least_normal<Scalar>(atol + rtol * of), 2);
            }
        },
        Y, base_);
    if (rtol > 0) worst.relative = std::sqrt(sum / std::max(1.0, static_cast<double>(residual_.size())));
    return worst;
  }

  FixedPointOptions options_;
  Plain base_;
  Unknown increment_, image_, residual_;  // w, g(w), f = g(w) − w
  Anderson<Scalar, static_unknowns<S>> anderson_;
  std::array<Scalar, Rhs::blocks> scale_{};
  std::array<double, Rhs::blocks> sizes_{};
};

template <State S, class Rhs, bool position>
struct ResolventFor<S, Rhs, FixedPoint, position> {
  using type = FixedPointResolvent<S, Rhs>;
};

/// Verlet's solve for v where the force has no Jacobian: Newton with dense differences for few unknowns, fixed-point
/// iteration for more than those are allowed for. v alone is mild: γ‖M⁻¹∂Ψ/∂v‖ < 1 wherever the explicit half is stable.
template <State S, class Rhs>
class VelocityResolvent {
  using Dense = NewtonResolvent<S, Rhs, void, false>;
  using Iterated = FixedPointResolvent<S, Rhs>;

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;

  VelocityResolvent(const Plain& y, Rhs& rhs, const Newton<>& solver)
      : solver_{solver}, chosen_{choose(y, rhs, solver)} {}
  void resize(const Plain& y, Rhs& rhs) { chosen_ = choose(y, rhs, solver_); }
  void forget() {
    std::visit([](auto& one) { one.forget(); }, chosen_);
  }
  void reset() {
    std::visit([](auto& one) { one.reset(); }, chosen_);
  }
  void forget_unsaved() { reset(); }
  [[nodiscard]] Outcome resolve(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, Plain& Y, const Plain& guess, Rate& psi,
                                Failure& history, bool psi_known = false, SolveTolerance<Plain> allowed = {}) {
    return std::visit([&](auto& one) { return one.resolve(rhs, gamma, t, Y, guess, psi, history, psi_known, allowed); },
                      chosen_);
  }
  [[nodiscard]] Outcome filter(Rhs& rhs, Plain& e) {
    return std::visit([&](auto& one) { return one.filter(rhs, e); }, chosen_);
  }
  [[nodiscard]] bool keeps_factors() const {
    return std::visit([](const auto& one) { return one.keeps_factors(); }, chosen_);
  }
  [[nodiscard]] const char* solver_name() const {
    return std::visit([](const auto& one) { return one.solver_name(); }, chosen_);
  }
  void add_increment(Scalar factor, Plain& out) const {
    std::visit([&](const auto& one) { one.add_increment(factor, out); }, chosen_);
  }
  void recover(const Rhs& rhs, Scalar gamma_force, Rate& psi) const {
    std::visit([&](const auto& one) { one.recover(rhs, gamma_force, psi); }, chosen_);
  }

 private:
  using Either = std::variant<Dense, Iterated>;
  [[nodiscard]] static Either choose(const Plain& y, Rhs& rhs, const Newton<>& solver) {
    if (unknowns<S>(y) <= dense_difference_limit) return Either{std::in_place_index<0>, y, rhs, solver};
    const NewtonOptions& o = solver.options;
    return Either{std::in_place_index<1>, y, rhs, fixed_point({o.rtol, o.atol, o.max_iterations})};
  }
  Newton<> solver_;
  Either chosen_;
};

template <State S, class Rhs>
  requires(static_unknowns<S> == Eigen::Dynamic && !Rhs::Traits::has_velocity_jacobian && !Rhs::Traits::has_pattern &&
           !solves_particlewise<S, Rhs>)
struct ResolventFor<S, Rhs, Newton<>, false> {
  using type = VelocityResolvent<S, Rhs>;
};

}  // namespace phistep::inline PHISTEP_ABI
