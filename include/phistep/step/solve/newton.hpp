/// @file
/// Newton's iteration. It knows residuals, corrections and their sizes, never time.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/step/solve/convergence.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Jacobian and factors serve the next step too where θ is at most this. To rounding a slow matrix costs many iterations:
/// RADAU5's choice (HW II p. 121). To a tolerance it costs one or two, a Jacobian n force calls.
[[nodiscard]] constexpr double keep_jacobian_rate(const NewtonOptions& options) {
  return options.rtol > 0 ? 0.05 : 1e-3;
}

/// F(Y) = 0, with Newton's matrix W, as the iteration sees it.
template <class Iterate>
concept NewtonIterate = requires(Iterate& F) {
  { F.residual() } -> std::same_as<Outcome>;           // F at the current iterate; non_finite_force where Ψ isn't
  { F.residual_size() } -> std::same_as<double>;       // ‖M⁻¹F‖, for the line search
  { F.residual_is_rounding() } -> std::same_as<bool>;  // no larger than the rounding in its parts
  { F.residual_is_noise() } -> std::same_as<bool>;     // no larger than rounding in what those parts are made of
  { F.has_jacobian() } -> std::same_as<bool>;
  { F.has_factors() } -> std::same_as<bool>;
  { F.refresh() } -> std::same_as<Outcome>;  // W, factorized, its Jacobian made anew if dropped
  { F.correct() } -> std::same_as<Outcome>;  // solves W δ = F and moves the iterate by δ
  { F.size() } -> std::same_as<Correction>;  // of the last move
  F.retreat();                               // takes back half of the last move
  F.undo();                                  // takes back all of it
  F.restart();                               // goes back to where the iteration began
  F.drop_jacobian();                         // the next iteration needs a fresh one
};

/// @param k         corrections done before, and now
/// @param inherits  earlier solves have left something that this one uses; false where it fails before it has used that
template <NewtonIterate Iterate>
[[nodiscard]] Outcome iterate_newton(Iterate& iterate, ConvergenceTest& test, double keep_rate, bool line_search,
                                     SolveRecord& record, int& k, bool& inherits) {
  using enum Judgement;
  bool own = false;  // the matrix was made in this solve
  double first = 0, last = 0, residual = 0;
  iterate.restart();
  for (bool at_start = true; test.allows(k + 1); at_start = false) {
    ++k;
    bool here = false;  // the matrix was made at this iterate
    Outcome outcome = iterate.residual();
    // An iterate may leave the force's domain (a root, a logarithm) though the solution lies inside.
    for (int halvings = 0; outcome == Outcome::non_finite_force && !at_start && halvings < 10; ++halvings) {
      iterate.retreat();
      test.forget();  // the next correction is the other half by construction
      outcome = iterate.residual();
    }
    if (failed(outcome)) {
      inherits = inherits && !at_start;
      return outcome;
    }
    if (line_search) {
      // Armijo's rule for F: a correction must shrink ‖M⁻¹F‖ by 1e-4 of what its length promises (Dennis & Schnabel,
      // Numerical Methods for Unconstrained Optimization and Nonlinear Equations, sect. 6.3).
      double size = iterate.residual_size(), length = 1;
      for (int halvings = 0; !at_start && halvings < 4 && size > (1 - 1e-4 * length) * residual; ++halvings) {
        if (iterate.residual_is_rounding()) break;
        iterate.retreat();
        test.forget();
        length /= 2;
        if (const Outcome bad = iterate.residual(); failed(bad)) return bad;
        size = iterate.residual_size();
      }
      residual = size;
      if (!at_start) iterate.drop_jacobian();  // only the tangent of this very place points downhill
    }
    if (!iterate.has_factors()) {
      here = !iterate.has_jacobian();  // a new γ alone makes new factors of an old Jacobian
      if (const Outcome bad = iterate.refresh(); failed(bad)) return bad;
      own = own || here;
    }
    // What `trusted`, `settled` and `noise` mean: ConvergenceTest::judge.
    // What an iterative solver leaves may hide what is left to do: a stiff or heavy part's residual that of a soft one.
    constexpr bool is_inexact = requires { requires Iterate::is_inexact; };
    // To a tolerance its solve ends at once where the residual is small enough: then no correction is needed.
    const bool trusted =
        (is_inexact ? (own && !at_start) || !test.is_to_rounding() : own) || iterate.residual_is_rounding();
    const bool noise = own && !here && test.is_to_rounding() && iterate.residual_is_noise();
    const bool settled = noise || here || !own || !test.is_to_rounding();
    if (const Outcome bad = iterate.correct(); failed(bad)) return bad;
    const Correction size = iterate.size();
    record.add(size.relative);
    (at_start ? first : last) = size.absolute;
    if (size.is_new) {
      test.forget();
      continue;
    }
    const Judgement judgement = test.judge(k, size, trusted, settled, noise);
    if (judgement == converged) {
      if (test.first_rate() > keep_rate) iterate.drop_jacobian();
      return Outcome::success;
    }
    if (judgement == go_on) continue;
    if (!own) return Outcome::newton_stalled;
    iterate.drop_jacobian();
    if (judgement == growing && !here && !line_search) {
      // A matrix of an earlier iterate may have thrown this one anywhere: from there, Newton might find another root.
      iterate.undo();
      test.forget();
    }
  }
  iterate.drop_jacobian();
  // A cycle keeps its size: that is a stall.
  return last > 10 * first ? Outcome::newton_diverged : Outcome::newton_stalled;
}

/// iterate_newton, and where it fails with a matrix or a rate that earlier solves have left, again without them: no solve fails
/// for what was before.
template <NewtonIterate Iterate>
[[nodiscard]] Outcome iterate_or_start_anew(Iterate& iterate, ConvergenceTest& test, double keep_rate, bool line_search,
                                            SolveRecord& record) {
  bool inherits = iterate.has_jacobian() || iterate.has_factors() || test.has_past();
  for (int k = 0;; test.start_over(k)) {
    const Outcome outcome = iterate_newton(iterate, test, keep_rate, line_search, record, k, inherits);
    if (outcome == Outcome::success || !std::exchange(inherits, false)) return outcome;
    iterate.drop_jacobian();
  }
}

/// To rounding, or to the options' tolerance: a second time with damped corrections where plain ones diverge, cycle or leave
/// the domain.
/// @param rate  how fast the first corrections of the solve before fell, and now of this; 0: not known
template <NewtonIterate Iterate>
[[nodiscard]] Outcome solve_newton(Iterate& iterate, const NewtonOptions& options, double round_off,
                                   SolveRecord& record, double& rate) {
  Outcome first = Outcome::success;
  for (bool line_search = options.line_search;; line_search = true) {
    ConvergenceTest test(options, round_off, rate);
    const Outcome outcome = iterate_or_start_anew(iterate, test, keep_jacobian_rate(options), line_search, record);
    rate = outcome == Outcome::success ? test.first_rate() : 0;
    if (outcome == Outcome::success) return outcome;
    if (first != Outcome::success) return first;
    if (line_search || (outcome != Outcome::newton_diverged && outcome != Outcome::newton_stalled)) return outcome;
    first = outcome;
  }
}

// The implicit solve under an affine force: one linear solve, no iteration. Trust, but verify: the residual that a solve leaves
// must be rounding. It is checked in some of them, counted from when the matrix was made (`is_looked_at`).

class AffineSolve {
 public:
  /// @param iterate  of the resolve (resolvent.hpp), with its matrix and increment
  /// @param unit      ε of the numbers
  template <bool drifts>
  [[nodiscard]] Outcome solve(auto& iterate, auto& matrix, auto& increment, double linear_rtol, double unit) {
    const auto start = [&](bool at_position) {
      if constexpr (drifts)
        if (at_position) return increment.start_at_position(iterate.Y, iterate.guess);
      iterate.restart();
    };
    bool at_position = matrix.has_factors() && is_stiff<drifts>(iterate.gamma, matrix);
    start(at_position);
    if (const Outcome bad = iterate.residual(); failed(bad)) return bad;
    if (!matrix.has_factors()) {
      solved_ = 0;
      if (const Outcome bad = iterate.refresh(); failed(bad)) return bad;
      if (is_stiff<drifts>(iterate.gamma, matrix) != at_position) {
        at_position = !at_position;
        start(at_position);
        if (const Outcome bad = iterate.residual(); failed(bad)) return bad;
      }
    }
    const bool looks = is_looked_at(solved_ + 1);
    const double before = looks ? largest(increment.delta) : 0;
    if (const Outcome bad = iterate.solve(); failed(bad)) return bad;
    increment.move_once(iterate.Y, at_position);
    if (matrix.staleness(iterate.gamma) > 0) {  // a second solve corrects what factors of another γ have left
      if (const Outcome bad = iterate.residual(); failed(bad)) return bad;
      if (const Outcome bad = iterate.solve(); failed(bad)) return bad;
      increment.move_once(iterate.Y, at_position);
    }
    ++solved_;
    if (!looks) return Outcome::success;
    if (const Outcome bad = iterate.residual(); failed(bad)) return bad;
    // What rounding, and an iterative solver's tolerance, may leave of the residual.
    double allowed = 1e4 * unit * iterate.terms();
    if constexpr (std::remove_cvref_t<decltype(iterate)>::is_inexact)
      allowed += 10 * linear_rtol * before * std::sqrt(static_cast<double>(increment.w.size()));
    if (largest(increment.delta) <= allowed) return Outcome::success;
    matrix.drop();
    return Outcome::not_affine;
  }

 private:
  /// From a = √(γ_f γ_d) ω = 16 on, the displacement is the better unknown. From v, a step is two shears whatever rounding
  /// did to W, so that at φ = ½ nothing drifts, but γv rounds r by a·u; from r, 1/W's rounding is in r and in v alike, and
  /// the energy drifts by up to two roundings a step, always the same way: after (8a)² = 1e4 steps that is the greater evil.
  template <bool drifts>
  [[nodiscard]] static bool is_stiff(const auto& gamma, const auto& matrix) {
    constexpr double a_squared = 256;
    return drifts && gamma.drift != 0 && matrix.drift_share() > a_squared / (1 + a_squared);
  }

  std::uint64_t solved_ = 0;  // since its matrix was made
};

}}  // namespace phistep::PHISTEP_ABI
