/// @file
/// The implicit solve under an affine force: one linear solve, no iteration. Trust, but verify: the residual that a solve leaves
/// must be rounding. It is looked at in some of them, counted from when the matrix was made (`is_looked_at`).
#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

class AffineSolve {
 public:
  /// @param equation  of the resolve (resolvent.hpp), with its matrix and increment
  /// @param unit      ε of the numbers
  template <bool drifts>
  [[nodiscard]] Outcome run(auto& equation, auto& matrix, auto& increment, double linear_rtol, double unit) {
    const auto start = [&](bool at_position) {
      if constexpr (drifts)
        if (at_position) return increment.start_at_position(equation.Y, equation.guess);
      equation.restart();
    };
    bool at_position = matrix.has_factors() && is_stiff<drifts>(equation.gamma, matrix);
    start(at_position);
    if (const Outcome bad = equation.residual(); failed(bad)) return bad;
    if (!matrix.has_factors()) {
      solved_ = 0;
      if (const Outcome bad = equation.refresh(); failed(bad)) return bad;
      if (is_stiff<drifts>(equation.gamma, matrix) != at_position) {
        at_position = !at_position;
        start(at_position);
        if (const Outcome bad = equation.residual(); failed(bad)) return bad;
      }
    }
    const bool looks = is_looked_at(solved_ + 1);
    const double before = looks ? largest(increment.delta) : 0;
    if (const Outcome bad = equation.solve(); failed(bad)) return bad;
    increment.move_once(equation.Y, at_position);
    if (matrix.staleness(equation.gamma) > 0) {  // a second solve corrects what factors of another γ have left
      if (const Outcome bad = equation.residual(); failed(bad)) return bad;
      if (const Outcome bad = equation.solve(); failed(bad)) return bad;
      increment.move_once(equation.Y, at_position);
    }
    ++solved_;
    if (!looks) return Outcome::success;
    if (const Outcome bad = equation.residual(); failed(bad)) return bad;
    // What rounding, and an iterative solver's tolerance, may leave of the residual.
    double allowed = 1e4 * unit * equation.terms();
    if constexpr (std::remove_cvref_t<decltype(equation)>::is_inexact)
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
