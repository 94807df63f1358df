/// @file
/// Newton's iteration. It knows residuals, corrections and their sizes, never time.
///
/// Two ways to stop:
/// - to rounding (default): until the predicted remaining error θ/(1−θ)·‖δ‖ is below the unit round-off, or until ‖δ‖
///   has stopped falling at the noise that rounding in Ψ makes (conservative runs drift otherwise);
/// - to a tolerance: RADAU5's test in the weighted RMS norm (Hairer & Wanner, Solving ODEs II, sect. IV.8, p. 120-121),
///   with its fnewt and at most 7 iterations.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "phistep/core/arithmetic.hpp"
#include "phistep/core/implicit_solver.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The size of one correction δ.
struct Correction {
  double relative = 0;    ///< ‖δ‖ / ‖Y‖ (to rounding), or ‖δ‖ in the weighted RMS norm (to a tolerance)
  double resolution = 0;  ///< ‖δ‖ relative to everything that rounding may have touched: Y, its base, r/γ
  double absolute = 0;    ///< ‖δ‖ itself
};

/// δ relative to the size of what it corrects, 1 where that is nothing. Subnormal numbers are all rounded alike: there, it is
/// relative to the least normal one.
template <class Scalar>
[[nodiscard]] double relative_size(double delta, double size) {
  return size > 0 ? delta / at_least_normal<Scalar>(size) : 1.0;
}

/// One solve's judgement of its corrections.
class ConvergenceTest {
 public:
  enum class Verdict { go_on, converged, slow, growing };

  /// For a controlled run. @param rate  θ/(1−θ) as the solves before left it: the first correction may then be the last
  /// (HW II, p. 121, with its exponent, which makes an old rate count less and less).
  ConvergenceTest(double target, int max_iterations, double rate, double round_off)
      : round_off_{round_off}, target_{target}, limit_{max_iterations > 0 ? max_iterations : 7} {
    // A lucky one says nothing of the next: a rate of 1e-5 is all that is believed.
    rate_ = std::pow(std::max(rate, 1e-5), 0.8);
  }

  /// To rounding or to the options' tolerance. @param last_rate  first_rate() of the solve before, 0: there was none
  ConvergenceTest(const NewtonOptions& options, double round_off, double last_rate = 0) : round_off_{round_off} {
    if (options.rtol > 0) {
      const double rtol = reduced(options.rtol);
      target_ = std::max(10 * round_off / rtol, std::min(0.03, std::sqrt(rtol)));
    }
    limit_ = options.max_iterations > 0 ? options.max_iterations : target_ > 0 ? 7 : 25;
    if (target_ == 0) last_rate_ = last_rate > 0 ? last_rate : slow_rate;
  }

  /// RADAU5's rescaling of the tolerance for its stage equations.
  [[nodiscard]] static double reduced(double rtol) { return 0.1 * std::cbrt(rtol * rtol); }

  /// Corrections of a solve at most; and whether there may be a k-th.
  [[nodiscard]] int limit() const { return limit_; }
  [[nodiscard]] bool allows(int k) const { return k - in_vain_ <= limit_; }
  [[nodiscard]] bool is_to_rounding() const { return target_ == 0; }
  /// θ/(1−θ), for the next solve.
  [[nodiscard]] double rate() const { return rate_; }
  /// The largest ‖δ_{k+1}‖/‖δ_k‖ of one matrix before the last correction: small means that it will do for the next step.
  [[nodiscard]] double first_rate() const { return first_rate_; }
  /// Whether it judges by the rate of an earlier solve.
  [[nodiscard]] bool has_past() const { return last_rate_ != 0 && last_rate_ != slow_rate; }
  /// The first k corrections count for nothing.
  void start_over(int k) {
    forget();
    in_vain_ = k;
  }
  /// The next correction has nothing to be compared with.
  void forget() {
    previous_ = 0;
    if (target_ == 0) last_rate_ = slow_rate;
  }

  /// @param trusted  the matrix was made in this solve, or the residual was nothing but rounding: a small correction
  ///                 then means a small error. An old matrix may be far too stiff and make any correction small.
  /// @param settled  the matrix is that of this very iterate, or the residual is as small as rounding can make it:
  ///                 corrections that no longer fall are then rounding. Those of an earlier iterate's matrix may creep,
  ///                 where it is too stiff (a spring that was long, across itself).
  /// @param noise    … and that was looked at: no solve can do better than a few roundings
  [[nodiscard]] Verdict judge(int iteration, const Correction& size, bool trusted, bool settled, bool noise = false) {
    const double now = size.relative;
    const bool has_rate = previous_ > 0;
    // Y may pass through zero on its way: progress is measured beside what stands still.
    const double theta = has_rate ? size.resolution / previous_ : 1;
    if (has_rate && iteration == 2) first_rate_ = theta;
    previous_ = size.resolution;
    if (now == 0) return trusted ? Verdict::converged : Verdict::slow;
    if (!has_rate) {
      if (rate_ > 0) return rate_ * now <= target_ ? Verdict::converged : Verdict::go_on;
      return trusted && target_ == 0 && now <= round_off_ ? Verdict::converged : Verdict::go_on;
    }
    // The first correction may be right by luck, in a direction that the matrix's error doesn't see: to rounding, the slower
    // of two successive rates counts.
    const double slower = target_ > 0 ? theta : std::max(theta, last_rate_);
    last_rate_ = theta;
    const double remaining = slower < 1 ? slower / (1 - slower) * now : std::numeric_limits<double>::infinity();
    if (rate_ > 0) rate_ = theta < 1 ? theta / (1 - theta) : 1;
    // Where the residual was noise, a few roundings are all that can be had.
    if (remaining <= (target_ > 0 ? target_ : noise ? 16 * round_off_ : round_off_)) return Verdict::converged;
    // Rounding in Ψ keeps ‖δ‖ from falling further; a cycle or a divergence has corrections of order one instead.
    if (target_ == 0 && trusted && settled && theta > 0.3 && is_at_plateau(size.resolution)) return Verdict::converged;
    if (theta > 1) return Verdict::growing;
    if (target_ == 0) return theta > slow_rate ? Verdict::slow : Verdict::go_on;
    const int left = limit_ - 1 - (iteration - in_vain_);
    return theta >= 0.99 || remaining * std::pow(theta, left) >= target_ ? Verdict::slow : Verdict::go_on;
  }

 private:
  /// ‖δ‖ ≤ u^⅔, without the price of a root for every small system.
  [[nodiscard]] bool is_at_plateau(double size) const { return size * size * size <= round_off_ * round_off_; }

  static constexpr double slow_rate =
      0.05;  // to rounding, a new matrix is cheaper than corrections that fall no faster
  double round_off_, target_ = 0, previous_ = 0, first_rate_ = 0, last_rate_ = 0;
  double rate_ = 0;  // 0: not known, two corrections at least
  int limit_, in_vain_ = 0;
};

/// Jacobian and factors serve the next step too where θ is at most this. To rounding a slow matrix costs many iterations:
/// RADAU5's choice (HW II p. 121). To a tolerance it costs one or two, a Jacobian n force calls.
[[nodiscard]] constexpr double keep_jacobian_rate(const NewtonOptions& options) {
  return options.rtol > 0 ? 0.05 : 1e-3;
}

/// Solves F(Y) = 0. The equation offers
///   residual() → Outcome         F at the current iterate; non_finite_force where Ψ isn't
///   residual_size() → double     ‖M⁻¹F‖, for the line search
///   residual_is_rounding()       whether F is no larger than the rounding in its parts
///   residual_is_noise()          … or in what these were made of, the positions of stiff springs say
///   has_jacobian(), has_factors()
///   refresh() → Outcome          the matrix, factorised (its Jacobian made anew if dropped)
///   correct() → Outcome          solves W δ = F and moves the iterate by δ
///   retreat(), undo()            takes back half of the last move, or all of it
///   restart()                    goes back to where the iteration began
///   size() → Correction          of the last move
///   drop_jacobian()              the next iteration needs a fresh one
/// @param k         corrections done before, and now
/// @param inherits  earlier solves have left something that this one uses; false where it fails before it has used that
template <class Equation>
[[nodiscard]] Outcome iterate_newton(Equation& equation, ConvergenceTest& test, double keep_rate, bool line_search,
                                     Failure& history, int& k, bool& inherits) {
  using enum ConvergenceTest::Verdict;
  bool own = false;  // the matrix was made in this solve …
  double first = 0, last = 0, residual = 0;
  equation.restart();
  for (bool at_start = true; test.allows(k + 1); at_start = false) {
    ++k;
    bool here = false;  // … and at this very iterate
    Outcome outcome = equation.residual();
    // An iterate may leave the force's domain (a root, a logarithm) though the solution lies inside.
    for (int halvings = 0; outcome == Outcome::non_finite_force && !at_start && halvings < 10; ++halvings) {
      equation.retreat();
      test.forget();  // the next correction is the other half by construction
      outcome = equation.residual();
    }
    if (outcome != Outcome::success) {
      inherits = inherits && !at_start;
      return outcome;
    }
    if (line_search) {
      // Armijo's rule for F: a correction must shrink ‖M⁻¹F‖ by 1e-4 of what its length promises (Dennis & Schnabel,
      // Numerical Methods for Unconstrained Optimization and Nonlinear Equations, sect. 6.3).
      double size = equation.residual_size(), length = 1;
      for (int halvings = 0; !at_start && halvings < 4 && size > (1 - 1e-4 * length) * residual; ++halvings) {
        if (equation.residual_is_rounding()) break;
        equation.retreat();
        test.forget();
        length /= 2;
        if (outcome = equation.residual(); outcome != Outcome::success) return outcome;
        size = equation.residual_size();
      }
      residual = size;
      if (!at_start) equation.drop_jacobian();  // only the tangent of this very place points downhill
    }
    if (!equation.has_factors()) {
      here = !equation.has_jacobian();  // a new γ alone makes new factors of an old Jacobian
      outcome = equation.refresh();
      if (outcome != Outcome::success) return outcome;
      own = own || here;
    }
    // What an iterative solver leaves may hide what is left to do: a stiff or heavy part's residual that of a soft one.
    constexpr bool is_inexact = requires { requires Equation::is_inexact; };
    const bool trusted = (own && !(is_inexact && at_start)) || equation.residual_is_rounding();
    const bool noise = own && !here && test.is_to_rounding() && equation.residual_is_noise();
    const bool settled = noise || here || !own || !test.is_to_rounding();
    outcome = equation.correct();
    if (outcome != Outcome::success) return outcome;
    const Correction size = equation.size();
    history.record(size.relative);
    (at_start ? first : last) = size.absolute;
    const auto verdict = test.judge(k, size, trusted, settled, noise);
    if (verdict == converged) {
      if (test.first_rate() > keep_rate) equation.drop_jacobian();
      return Outcome::success;
    }
    if (verdict == go_on) continue;
    if (!own) return Outcome::newton_stalled;
    equation.drop_jacobian();
    if (verdict == growing && !here && !line_search) {
      // A matrix of an earlier iterate may have thrown this one anywhere: from there, Newton might find another root.
      equation.undo();
      test.forget();
    }
  }
  equation.drop_jacobian();
  // A cycle keeps its size: that is a stall.
  return last > 10 * first ? Outcome::newton_diverged : Outcome::newton_stalled;
}

/// The same, and where it fails with a matrix or a rate that earlier solves have left, again without them: no solve fails
/// for what was before.
template <class Equation>
[[nodiscard]] Outcome solve_newton(Equation& equation, ConvergenceTest& test, double keep_rate, bool line_search,
                                   Failure& history) {
  bool inherits = equation.has_jacobian() || equation.has_factors() || test.has_past();
  for (int k = 0;; test.start_over(k)) {
    const Outcome outcome = iterate_newton(equation, test, keep_rate, line_search, history, k, inherits);
    if (outcome == Outcome::success || !std::exchange(inherits, false)) return outcome;
    equation.drop_jacobian();
  }
}

/// To rounding, or to the options' tolerance: a second time with damped corrections where plain ones diverge, cycle or leave
/// the domain.
/// @param rate  how fast the first corrections of the solve before fell, and now of this; 0: not known
template <class Equation>
[[nodiscard]] Outcome solve_newton(Equation& equation, const NewtonOptions& options, double round_off, Failure& history,
                                   double& rate) {
  Outcome first = Outcome::success;
  for (bool line_search = options.line_search;; line_search = true) {
    ConvergenceTest test(options, round_off, rate);
    const Outcome outcome = solve_newton(equation, test, keep_jacobian_rate(options), line_search, history);
    rate = outcome == Outcome::success ? test.first_rate() : 0;
    if (outcome == Outcome::success) return outcome;
    if (first != Outcome::success) return first;
    if (line_search || (outcome != Outcome::newton_diverged && outcome != Outcome::newton_stalled)) return outcome;
    first = outcome;
  }
}

}  // namespace phistep::inline PHISTEP_ABI
