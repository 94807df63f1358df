/// @file
/// What Rosenbrock schemes are made of: one linearization a step, and linear resolves
///
///     (M − γJ) x = b                                                                                            (1)
///
/// with one or a few γ. For motion, J couples x = (x_r, x_v) by x_r' = x_v, so that (1) is n equations, not 2n:
///
///     x_r = b_r + γ x_v,     (M − γC − γ²K) x_v = b_v + γ K b_r                                                 (2)
///
/// (Hairer & Wanner, Solving ODEs II, sect. IV.7, eq. 7.4').
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/jacobian/tangent_check.hpp"
#include "phistep/step/solve/linearization.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State S, class Rhs, class LinearSolver>
class LinearStages {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Matrix = Linearization<S, Rhs, LinearSolver, true, true>;
  static constexpr bool solves_by_factors = !Matrix::is_iterative;
  static constexpr bool has_time = !Rhs::is_autonomous;
  static constexpr bool affine = Rhs::Traits::is_affine && !Matrix::matrix_free;
  static constexpr bool is_promised = Matrix::is_promised;  // and so has to be checked

  LinearStages(const Plain& y, Rhs& rhs, const auto& solver) : options_{solver.options} {
    has_user_tolerance_ = options_.linear_rtol > 0;
    // No second correction makes up for what an iterative solver leaves.
    if (Matrix::is_iterative && options_.linear_rtol == 0) options_.linear_rtol = std::max(1e-10, 16 * round_off);
    matrix_.take(solver);
    resize(y, rhs);
  }
  void resize(const Plain& y, Rhs& rhs) {
    matrix_.resize(y, rhs);  // may throw, so it comes first
    y_ = y;
    psi_ = make_rate<S>(y);
    if constexpr (has_time) psi_t_ = later_ = make_rate<S>(y);
    if constexpr (!FieldState<S>) x_.setZero(unknowns<S>(y));
    if constexpr (solved_blocks<S> != 1) positions_ = x_;
    if constexpr (is_promised) check_.resize(y);
    known_ = false;
  }
  /// Forgets what solves have left.
  void forget() {
    matrix_.forget_solves();
    known_ = false;
  }
  /// Forgets also what was found out about the force, which may be another one.
  void reset() {
    forget();
    matrix_.forget();
    if constexpr (is_promised) check_.begin();
  }
  /// Forgets also the matrix's pattern: the state after construction.
  void forget_unsaved() {
    reset();
    matrix_.forget_pattern();
  }
  /// Forgets Ψ: the history may be another one.
  void forget_force() { known_ = false; }

  /// Ψ, J and, where the force uses time, Ψ_t at (t, y). A step that is tried again with another Δt finds them there.
  /// @param dt         [time] with its sign: over which differences in time are taken
  /// @param knows_psi  psi is Ψ(t, y)
  [[nodiscard]] Outcome linearize(Rhs& rhs, Scalar t, Scalar dt, const Plain& y, Rate& psi, bool knows_psi,
                                  const SolveTolerance<Plain>& allowed) {
    allowed_ = has_user_tolerance_ ? SolveTolerance<Plain>{} : allowed;
    if (known_ && same_bits(&t, &t_, 1) && equal_blocks<S>(y, y_)) {
      psi = psi_;
      return Outcome::success;
    }
    known_ = false;
    t_ = t;
    copy_blocks<S>(y_, y);
    if (!knows_psi) rhs.evaluate_into(t, y, psi);
    // For a field the size of the first right-hand side shows it.
    if (!Matrix::sizes(options_, allowed_) && !knows_psi && first_non_finite(Rate::blocks(psi)))
      return Outcome::non_finite_force;
    psi_ = psi;
    if constexpr (has_time)
      if (const Outcome outcome = differ_in_time(rhs, t, dt, y); outcome != Outcome::success) return outcome;
    if (!affine || !matrix_.has_jacobian()) {
      matrix_.drop();
      const Gamma<Scalar> gamma{dt, dt};
      matrix_.begin(gamma, Scalar{0});
      if (const Outcome bad = matrix_.linearize(rhs, gamma, t, y_, psi_, options_, allowed); failed(bad)) return bad;
    }
    known_ = !Rhs::has_history;
    if constexpr (is_promised) check_.count();
    return Outcome::success;
  }
  /// W = M − γC − γ²K
  [[nodiscard]] Outcome factorize(Rhs& rhs, Scalar gamma) {
    const Gamma<Scalar> both{gamma, gamma};
    if (!affine || !matrix_.has_factors_for(both)) {
      [[maybe_unused]] const auto patterns = rhs.statistics().analyses;
      if (const Outcome bad = matrix_.refresh(rhs, both, t_, y_, psi_, options_, allowed_); failed(bad)) return bad;
      if constexpr (is_promised)
        if (patterns != rhs.statistics().analyses) check_.want();
    }
    if constexpr (is_promised)
      if (check_.is_due()) {
        const Outcome outcome = check_.look(rhs, matrix_, options_, both, t_, y_, psi_);
        if (outcome != Outcome::success) reset();
        return outcome;
      }
    return Outcome::success;
  }
  /// (1), in place, by (2) for motion: b_v in units of M v. Of small systems, what is not finite shows in x alone.
  [[nodiscard]] Outcome solve(Rhs& rhs, Scalar gamma, Plain& x) {
    if constexpr (Matrix::solves_in_registers && !Rhs::drifts && solved_blocks<S> == 1) {
      auto unknown = flat(std::get<0>(Blocks<S>::solved(x)));
      matrix_.solve_unchecked(unknown, rhs.statistics());
      return Outcome::success;
    }
    if constexpr (FieldState<S>) {
      const Outcome outcome =
          matrix_.solve_unagreed(std::get<0>(Blocks<S>::solved(x)), options_, rhs.statistics(), allowed_);
      known_ = known_ && !failed(outcome);
      return outcome;
    } else {
      take_unknowns<S>(x_, x);
      if constexpr (Rhs::drifts) add_position_product(gamma, flat(position_of<S>(std::as_const(x))));
      if (const Outcome bad = matrix_.solve(x_, options_, rhs.statistics(), allowed_); failed(bad))
        return first_non_finite(Blocks<S>::all(x)) ? Outcome::non_finite_state : bad;  // W is not the cause
      put_unknowns<S>(x_, x);
      if constexpr (Rhs::drifts) position_of<S>(x) += gamma * velocity_of<S>(x);
      return Outcome::success;
    }
  }
  /// Whether solves iterate until what they leave is small beside the error of the step.
  static constexpr bool iterates = Matrix::is_iterative;
  [[nodiscard]] bool follows_error() const { return iterates && allowed_.target > 0; }
  [[nodiscard]] const Rate& psi_t() const requires has_time { return psi_t_; }
  [[nodiscard]] Matrix& matrix() { return matrix_; }

  [[nodiscard]] const char* solver_name() const { return matrix_.name(); }

 private:
  static constexpr double round_off = static_cast<double>(std::numeric_limits<Scalar>::epsilon());

  /// Ψ_t = (−3Ψ(t) + 4Ψ(t+δ) − Ψ(t+2δ))/2δ: from inside the step, where the force is sure to be defined. With δ = u^¼ Δt,
  /// rounding leaves 4u^¾ of ΔtΨ_t, and the formula u^½ of Δt³Ψ_ttt. Divided by δ, a jump of Ψ at t would be 8000 jumps: from
  /// there on, or up to there, only.
  [[nodiscard]] Outcome differ_in_time(Rhs& rhs, Scalar t, Scalar dt, const Plain& y) requires has_time {
    const Scalar u = std::numeric_limits<Scalar>::epsilon();
    const Scalar least = 64 * u * std::abs(t), wanted = std::sqrt(std::sqrt(u)) * std::abs(dt);
    const Scalar from = rhs.inside(t), delta = (from + std::copysign(std::max(wanted, least), dt)) - from;
    rhs.evaluate_into(from + delta, y, later_);
    const Scalar half = 1 / (2 * delta);
    if constexpr (FieldState<S>) {
      assign_rate<S>(psi_t_, Scalar{-3} * in_rate<S>(psi_) + Scalar{4} * in_rate<S>(later_));
      rhs.evaluate_into(from + 2 * delta, y, later_);
      assign_rate<S>(psi_t_, half * (in_rate<S>(psi_t_) - in_rate<S>(later_)));
    } else {
      psi_t_ = later_;
      rhs.evaluate_into(from + 2 * delta, y, later_);
      for_each_number([half](auto, Scalar& b, Scalar a, Scalar c) { b = half * twice_change(a, b, c); },
                      Rate::blocks(psi_t_), Rate::blocks(psi_), Rate::blocks(later_));
    }
    return first_non_finite(Rate::blocks(psi_t_)) ? Outcome::non_finite_force : Outcome::success;
  }

  /// 2δ times the slope at the first of three values that are δ apart; where two differ by a jump, of the others.
  [[nodiscard]] static Scalar twice_change(Scalar a, Scalar b, Scalar c) {
    const Scalar first = b - a, second = c - b, least = std::abs(first) < std::abs(second) ? first : second;
    const bool jumps = std::abs(second - first) > Scalar{0.75} * (std::abs(first) + std::abs(second));
    return jumps ? 2 * least : Scalar{-3} * a + Scalar{4} * b - c;
  }

  /// x_ += γ K r. K has a column for each unknown: those of the positions come first, all others are zero.
  void add_position_product(Scalar gamma, const auto& r) {
    if constexpr (solved_blocks<S> == 1) {
      matrix_.add_position_product(gamma, r, x_);
    } else {
      positions_.head(r.size()) = r;
      matrix_.add_position_product(gamma, positions_, x_);
    }
  }

  NewtonOptions options_;
  Matrix matrix_;
  Plain y_;  // where Ψ and J are known
  Scalar t_{};
  Rate psi_;  // Ψ there
  [[no_unique_address]] Only<has_time, Rate> psi_t_, later_;
  [[no_unique_address]] Only<is_promised, TangentCheck<S, Rhs>> check_;
  [[no_unique_address]] Only<!FieldState<S>, Eigen::Matrix<Scalar, static_unknowns<S>, 1>> x_;
  Eigen::Matrix<Scalar, solved_blocks<S> == 1 ? 0 : static_unknowns<S>, 1> positions_;  // and zeros
  SolveTolerance<Plain> allowed_;                                                       // of the step at hand
  bool known_ = false;               // y_, t_, psi_ and J belong together
  bool has_user_tolerance_ = false;  // the options say how well to solve
};

}}  // namespace phistep::PHISTEP_ABI
