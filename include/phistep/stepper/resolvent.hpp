/// @file
/// The only implicit solve there is: given b and γ, find Y with
///
///     M (Y − b) = γ_f Ψ(t, Y),     and for motion  Y.r = b.r + γ_d Y.v,
///
/// by Newton on the increment w = Y − b of the solved blocks alone (n unknowns for a motion, not 2n), with the matrix
/// W = M − γ_f C − γ_f γ_d K.
///
/// Digits. Y = b + w would lose what a strong decay cancels (Y ≪ b), and b + w is the exact thing to store where nothing
/// cancels. So each component decides for itself: where |b + w| < |b|/2 the iterate is corrected in place, Y ← Y + δ,
/// which refines itself; elsewhere Y = b + w. The same rule serves r, v following from it. It replaces a choice between velocity,
/// displacement and absolute unknowns by stiffness, and knows no units.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/core/arithmetic.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/jacobian/analytic.hpp"
#include "phistep/jacobian/differences.hpp"
#include "phistep/resolve/dense_system.hpp"
#include "phistep/resolve/newton.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"
#include "phistep/stepper/difference_tangent.hpp"
#include "phistep/stepper/right_hand_side.hpp"

namespace phistep::inline PHISTEP_ABI {

/// `position` = false serves resolves with γ_d = 0 only (Verlet's last half-kick): no K, and terms that ignore v are
/// never asked for a tangent.
template <State S, class Rhs, class LinearSolver, bool position = true>
class NewtonResolvent {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Traits = typename Rhs::Traits;
  static constexpr int n_static = static_unknowns<S>;
  using Unknown = Eigen::Matrix<Scalar, n_static, 1>;
  static constexpr bool has_K = Rhs::drifts && position;
  static constexpr bool has_C = Rhs::couples_unknowns;
  static constexpr bool analytic = position ? Traits::has_jacobian : Traits::has_velocity_jacobian;
  static constexpr bool patterned = !analytic && Traits::has_pattern;
  static constexpr MatrixFacts facts = [] {
    MatrixFacts all{.has_K = has_K,
                    .has_C = has_C,
                    .symmetric = Traits::is_symmetric,
                    .constant = Traits::is_affine,
                    .block = Traits::block,
                    .differenced = !analytic};
    if (analytic || patterned) all.structure = position ? Traits::structure : Traits::velocity_structure;
    all.structure = combine(all.structure, Rhs::mass_structure);
    if (!std::is_void_v<LinearSolver>) all.structure = Structure::sparse;
    return all;
  }();
  using System = typename SystemFor<facts, Scalar, n_static, LinearSolver>::type;

  /// @throws std::invalid_argument where a dense Jacobian of more than 1000 unknowns would be formed by differences.
  NewtonResolvent(const Plain& y, const Rhs& rhs, const Newton<LinearSolver>& solver) : options_{solver.options} {
    resize(y, rhs);
  }

  void resize(const Plain& y, const Rhs& rhs) {
    const Index n = unknowns<S>(y);
    if (!analytic && !patterned && n > dense_difference_limit)
      throw std::invalid_argument("phistep: the Jacobian of " + std::to_string(n) +
                                  " unknowns by differences would be dense; give the force a member jacobian(...) "
                                  "(sparse for large systems), or add_jacobian(...) to its terms");
    if constexpr (!analytic) differences_.resize(y, rhs);  // may throw, so it comes before anything has a new size
    base_ = y;
    increment_.setZero(n);
    correction_.setZero(n);
    last_move_.setZero(n);
    system_.resize(n);
    drop_jacobian();
  }

  /// Forgets Jacobian and factors, and that the force is still the same.
  void reset() {
    drop_jacobian();
    if constexpr (!analytic) differences_.forget_pattern();
  }

  /// In: Y = b; `guess` is where the iteration starts (its solved blocks count). Out: Y, and w = Y − b.
  [[nodiscard]] Outcome resolve(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, Plain& Y, const Plain& guess, Rate& psi,
                                Failure& history) {
    copy_blocks<S>(base_, Y);
    if (gamma.force != factored_.force || gamma.drift != factored_.drift) has_factors_ = false;
    Equation equation{*this, rhs, gamma, t, Y, guess, psi};
    equation.restart();
    if constexpr (!analytic) differences_.begin();
    const int before = history.iterations;
    const Outcome outcome =
        solve_newton(equation, options_, static_cast<double>(std::numeric_limits<Scalar>::epsilon()), history);
    rhs.statistics().iterations += history.iterations - before;
    return outcome;
  }

  /// out.solved += factor·(Y − b) with the last resolve's increment.
  void add_increment(Scalar factor, Plain& out) const {
    for_each_solved<S>([&](Index at, auto& y) { flat(y) += factor * part(increment_, at, y); }, out);
  }

  /// Ψ(t, Y) = M (Y − b)/γ_f of the last resolve: known without a force call.
  void recover(const Rhs& rhs, Scalar gamma_force, Rate& psi) const {
    Index at = 0;
    for_each_block(
        [&](auto, auto& block, const auto& mass) {
          auto rate = flat(block);
          rate.setZero();
          mass.subtract_product(part(increment_, at, block), rate);
          rate *= Scalar{-1} / gamma_force;
          at += block.size();
        },
        Rate::blocks(psi), rhs.masses());
  }

 private:
  /// What solve_newton iterates on.
  struct Equation {
    NewtonResolvent& self;
    Rhs& rhs;
    const Gamma<Scalar>& gamma;
    Scalar t;
    Plain& Y;
    const Plain& guess;
    Rate& psi;

    void restart() {
      for_each_solved<S>(
          [this](Index at, auto& y, const auto& from, const auto& base) {
            part(self.increment_, at, y) = flat(from) - flat(base);
            y = from;
          },
          Y, guess, self.base_);
      if constexpr (Rhs::drifts) position_of<S>(Y) = position_of<S>(self.base_) + gamma.drift * velocity_of<S>(Y);
    }
    /// γ_f Ψ(t, Y) − M w
    [[nodiscard]] Outcome residual() {
      rhs.evaluate_into(t, Y, psi);
      assemble_residual();
      if (all_finite(self.correction_.data(), self.correction_.size())) return Outcome::success;
      return first_non_finite(Rate::blocks(psi)) ? Outcome::non_finite_force : Outcome::non_finite_state;
    }
    void assemble_residual() {
      Index at = 0;
      for_each_block(
          [&](auto, const auto& block, const auto& mass) {
            auto out = part(self.correction_, at, block);
            out = gamma.force * flat(block);
            mass.subtract_product(part(self.increment_, at, block), out);
            at += block.size();
          },
          Rate::blocks(std::as_const(psi)), rhs.masses());
    }
    /// No larger than what rounding leaves of γ_f Ψ − M w where both cancel.
    [[nodiscard]] bool residual_is_rounding() const {
      bool rounding = true;
      Index at = 0;
      for_each_block(
          [&](auto, const auto& block) {
            const double force = std::abs(static_cast<double>(gamma.force)) * largest(block);
            rounding = rounding && largest(part(self.correction_, at, block)) <=
                                       8 * static_cast<double>(std::numeric_limits<Scalar>::epsilon()) * force;
            at += block.size();
          },
          Rate::blocks(std::as_const(psi)));
      return rounding;
    }
    [[nodiscard]] bool has_jacobian() const { return self.has_jacobian_; }
    [[nodiscard]] bool has_factors() const {
      if constexpr (requires { self.system_.has_solver(); }) return self.has_factors_ && self.system_.has_solver();
      else return self.has_factors_;
    }
    void drop_jacobian() { self.drop_jacobian(); }
    [[nodiscard]] Outcome refresh() {
      if (!self.has_jacobian_)
        if (const Outcome outcome = self.linearise(rhs, gamma, t, Y, psi); outcome != Outcome::success) return outcome;
      return self.factorize(rhs, gamma);
    }
    [[nodiscard]] Outcome correct() {
      if (const Outcome outcome = solve(); outcome != Outcome::success) return outcome;
      if constexpr (!analytic)
        while (self.differences_.reached_too_far(Y, self.correction_)) {
          // The tangent belongs to another place than the correction it made.
          assemble_residual();
          if (Outcome outcome = self.linearise(rhs, gamma, t, Y, psi); outcome != Outcome::success) return outcome;
          if (Outcome outcome = self.factorize(rhs, gamma); outcome != Outcome::success) return outcome;
          if (Outcome outcome = solve(); outcome != Outcome::success) return outcome;
        }
      self.last_move_ = self.correction_;
      self.move(Y, gamma);
      return Outcome::success;
    }
    [[nodiscard]] Outcome solve() {
      ++rhs.statistics().solves;
      if (const Outcome outcome = self.system_.solve(self.correction_); outcome != Outcome::success) return outcome;
      return all_finite(self.correction_.data(), self.correction_.size()) ? Outcome::success : Outcome::singular_matrix;
    }
    void retreat() {
      self.last_move_ *= Scalar{0.5};
      undo();
    }
    void undo() {
      self.correction_ = -self.last_move_;
      self.move(Y, gamma);
    }
    [[nodiscard]] Correction size() const { return self.size(Y, gamma); }
  };

  /// Y ← Y + δ, component by component by the rule in the file's head.
  void move(Plain& Y, const Gamma<Scalar>& gamma) {
    increment_ += correction_;
    for_each_solved<S>(
        [this](Index at, auto& y, const auto& base) {
          for (Index i = 0; i < y.size(); ++i)
            y.data()[i] = refined(base.data()[i], increment_[at + i], y.data()[i], correction_[at + i]);
        },
        Y, base_);
    if constexpr (Rhs::drifts) {
      Scalar *const r = position_of<S>(Y).data(), *const v = velocity_of<S>(Y).data();
      const Scalar* const base = position_of<S>(base_).data();
      for (Index i = 0; i < position_of<S>(Y).size(); ++i) {
        const Scalar sum = base[i] + gamma.drift * v[i];
        if (std::abs(sum) < std::abs(base[i]) / 2) {
          r[i] += gamma.drift * correction_[i];
          v[i] = (r[i] - base[i]) / gamma.drift;  // no digits lost here: r is small beside its base
        } else {
          r[i] = sum;
        }
      }
    }
  }
  static Scalar refined(Scalar base, Scalar increment, Scalar iterate, Scalar correction) {
    const Scalar sum = base + increment;
    return std::abs(sum) < std::abs(base) / 2 ? iterate + correction : sum;
  }

  [[nodiscard]] Correction size(const Plain& Y, const Gamma<Scalar>& gamma) const {
    if (options_.rtol > 0) return weighted_size(Y);
    Correction worst;
    bool first = true;
    for_each_solved<S>(
        [&](Index at, const auto& y, const auto& base) {
          const double delta = largest(part(last_move_, at, y)), size = largest(y);
          double resolution = std::max(size, largest(base));
          // Rounding of r reaches δ through K alone: all of it where springs are stiff, nothing where there are none.
          if constexpr (Rhs::drifts && has_K)
            if (first && gamma.drift != Scalar{0})
              resolution = std::max(resolution, system_.drift_share() * largest(position_of<S>(Y)) /
                                                    std::abs(static_cast<double>(gamma.drift)));
          first = false;
          worst.absolute = std::max(worst.absolute, delta);
          if (delta > 0) {
            worst.relative = std::max(worst.relative, size > 0 ? delta / size : 1.0);
            worst.resolution = std::max(worst.resolution, resolution > 0 ? delta / resolution : 1.0);
          }
        },
        Y, base_);
    return worst;
  }
  [[nodiscard]] Correction weighted_size(const Plain& Y) const {
    const double rtol = ConvergenceTest::reduced(options_.rtol), atol = rtol * options_.atol / options_.rtol;
    double sum = 0;
    for_each_solved<S>(
        [&](Index at, const auto& y, const auto& base) {
          for (Index i = 0; i < y.size(); ++i) {
            const double size = static_cast<double>(std::max(std::abs(y.data()[i]), std::abs(base.data()[i])));
            const double delta = static_cast<double>(last_move_[at + i]);
            if (delta != 0) sum += std::pow(delta / (atol + rtol * size), 2);
          }
        },
        Y, base_);
    const double norm = std::sqrt(sum / std::max(1.0, static_cast<double>(last_move_.size())));
    return {norm, norm, largest(last_move_)};
  }

  void drop_jacobian() { has_jacobian_ = has_factors_ = false; }

  /// K and C at (t, Y), where Ψ is psi.
  [[nodiscard]] Outcome linearise(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, const Plain& Y, const Rate& psi) {
    ++rhs.statistics().jacobians;
    system_.clear();
    if constexpr (analytic)
      add_jacobian<position, Rate, n_static>(rhs.force(), t, rhs.view(Y), rhs.trial_memory(), increment_.size(),
                                             system_);
    else differences_.compute(rhs, gamma, t, Y, psi, options_, system_);
    has_jacobian_ = system_.is_finite();
    return has_jacobian_ ? Outcome::success : Outcome::non_finite_jacobian;
  }

  [[nodiscard]] Outcome factorize(Rhs& rhs, const Gamma<Scalar>& gamma) {
    const auto each_mass_entry = [&](auto&& put) {
      Index at = 0;
      for_each_block(
          [&](auto, const auto& block, const auto& mass) {
            mass.for_each_entry(block.size(), [&](Index i, Index j, auto m) { put(at + i, at + j, m); });
            at += block.size();
          },
          Blocks<S>::solved(base_), rhs.masses());
    };
    const Outcome outcome = system_.factorize(each_mass_entry, gamma.force, gamma.drift, rhs.statistics());
    has_factors_ = outcome == Outcome::success;
    factored_ = gamma;
    return outcome;
  }

  struct Absent {};
  NewtonOptions options_;
  Plain base_;
  [[no_unique_address]] std::conditional_t<analytic, Absent, DifferenceTangent<S, Rhs, has_K, has_C>> differences_;
  Unknown increment_, correction_, last_move_;
  System system_;
  Gamma<Scalar> factored_{};
  bool has_jacobian_ = false, has_factors_ = false;
};

/// The resolvent behind each way to solve: Newton<…> here, others in headers of their own. All offer what NewtonResolvent
/// does: resize, reset, resolve, add_increment, recover.
template <State S, class Rhs, class Solver, bool position>
struct ResolventFor;
template <State S, class Rhs, class LinearSolver, bool position>
struct ResolventFor<S, Rhs, Newton<LinearSolver>, position> {
  using type = NewtonResolvent<S, Rhs, LinearSolver, position>;
};

}  // namespace phistep::inline PHISTEP_ABI
