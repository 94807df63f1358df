/// @file
/// Fixed-point iteration for w = g(w), with Anderson's acceleration: no Jacobian, no matrix.
///
/// Plain (Picard): w ← g(w). For M (Y − b) = γ Ψ(Y) it contracts by γ‖M⁻¹∂Ψ/∂y‖ each time; for an oscillator stepped with
/// φ, by φ²(ωΔt)² exactly: it converges for ωΔt < 1/φ only, explicit Verlet's own limit at φ = ½.
/// Accelerated (D. G. Anderson, J. ACM 12 (1965) 547; H. F. Walker and P. Ni, SIAM J. Numer. Anal. 49 (2011) 1715,
/// eqs. 2.1-2.2 and sect. 4): with f_k = g(w_k) − w_k and the last m differences ΔF, ΔG of f and g,
///
///     θ = argmin ‖f_k − ΔF θ‖,    w_{k+1} = g(w_k) − ΔG θ,
///
/// which is GMRES where g is linear. It widens the limit, but does not replace Newton far beyond it. Where g multiplies errors by
/// ρ > 1, the result is the last iterate w_k, with an error of f_k/ρ, and not its image g(w_k), with an error of f_k: that is ρ
/// times the rounding in Ψ.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "phistep/step/solve/convergence.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// When to stop, and how much to remember. rtol = 0 means: iterate to rounding.
struct FixedPointOptions {
  double rtol = 0;         ///< relative tolerance of the step that this solve serves
  double atol = 0;         ///< absolute tolerance, in the state's units
  int max_iterations = 0;  ///< 0: 25 with a tolerance, 200 to rounding
  int depth = 3;           ///< differences that Anderson's acceleration uses, 0 … 5; 0: plain iteration
};

/// Solves the implicit equations by fixed-point iteration.
struct FixedPoint {
  static constexpr bool is_implicit_solver = true;
  FixedPointOptions options;
};
/// For a stepper's last argument: `fixed_point()`, `fixed_point({.rtol = 1e-6})`, `fixed_point({.depth = 0})`.
/// @throws std::invalid_argument where depth isn't in 0 … 5
[[nodiscard]] constexpr FixedPoint fixed_point(FixedPointOptions options = {}) {
  if (options.depth < 0 || options.depth > 5)
    throw std::invalid_argument("phistep: the depth of Anderson's acceleration must be 0 to 5");
  return {options};
}

/// The judge of one solve by the sizes of its residuals f_k.
class FixedPointTest {
 public:
  /// @param target  of a controlled run, in whose norm sizes then are; 0: the options rule
  FixedPointTest(const FixedPointOptions& options, double round_off, double target = 0)
      : round_off_{round_off},
        target_{target > 0 ? target : solve_target(options.rtol, round_off)},
        patience_{options.depth == 0 ? 3 : options.depth + 5},
        limit_{options.max_iterations > 0 ? options.max_iterations
               : target_ > 0              ? 25
                                          : 200} {}

  /// @param stretches  the solve will end at w_k, not at its image: f_k itself has to be small
  [[nodiscard]] Judgement judge(int iteration, const Correction& size, bool stretches = false) {
    // Y may pass through zero on its way: progress is measured beside all that stands still, too.
    const double now = size.beside_all, theta = previous_ > 0 ? now / previous_ : 1;
    // Acceleration may make one correction small by chance: the slower of two successive rates counts.
    const double slower = std::max(theta, patience_ > 3 ? last_rate_ : theta);
    previous_ = now;
    last_rate_ = theta;
    if (now == 0) return Judgement::converged;
    const double left = std::max(error_left(slower, size.relative), stretches ? size.relative : 0.0);
    if (left <= (target_ > 0 ? target_ : round_off_)) return Judgement::converged;
    if (now < best_) {
      best_ = now;
      without_progress_ = 0;
    } else if (++without_progress_ >= (may_be_rounding(now, round_off_) ? 2 : patience_)) {
      if (may_be_rounding(now, round_off_)) return Judgement::converged;
      return now > 1.01 * best_ ? Judgement::growing : Judgement::slow;  // a cycle keeps its size
    }
    return iteration >= limit_ ? Judgement::slow : Judgement::go_on;
  }

 private:
  double round_off_, target_, previous_ = 0, last_rate_ = 1, best_ = std::numeric_limits<double>::infinity();
  int patience_, limit_, without_progress_ = 0;
};

/// The acceleration's memory for n unknowns. Allocates in resize() alone.
template <class Scalar, int n>
class Anderson {
 public:
  static constexpr int max_depth = 5;
  using Vector = Eigen::Matrix<Scalar, n, 1>;

  void resize(Eigen::Index size, int depth) {
    depth_ = depth;
    if (depth_ == 0) return;
    last_f_.setZero(size);
    last_g_.setZero(size);
    for (auto* columns : {&df_, &dg_, &q_})
      for (int c = 0; c < depth_; ++c) (*columns)[static_cast<std::size_t>(c)].setZero(size);
  }
  /// A new solve.
  void begin() { used_ = next_ = 0, has_last_ = stretches_ = false; }
  /// Whether g moved farther than w did in this solve, rounding apart.
  [[nodiscard]] bool stretches() const { return stretches_; }

  /// w ← g − ΔG θ. In: f = g(w) − w. @param inner  the inner product ⟨x, y⟩ of two columns in which ‖f‖ has a meaning, and the unknowns
  ///               a size of about one
  void mix(Vector& w, const Vector& f, const Vector& g, auto&& inner) {
    w = g;
    if (depth_ == 0) return;
    if (has_last_) {
      df_[next_] = f - last_f_;
      dg_[next_] = g - last_g_;
      const auto moved = dg_[next_] - df_[next_];  // w's
      const Scalar distance = inner(moved, moved);
      stretches_ =
          stretches_ || (distance > std::numeric_limits<Scalar>::epsilon() && inner(dg_[next_], dg_[next_]) > distance);
      next_ = (next_ + 1) % depth();
      used_ = std::min(used_ + 1, depth());
    }
    last_f_ = f;
    last_g_ = g;
    has_last_ = true;

    // Modified Gram-Schmidt, the newest difference first; one that adds nothing new to it is left out.
    std::array<std::array<Scalar, max_depth>, max_depth> R{};
    std::array<Scalar, max_depth> theta{};
    std::array<std::size_t, max_depth> column{};
    std::size_t rank = 0;
    for (std::size_t age = 0; age < used_; ++age) {
      const std::size_t c = (next_ + 2 * depth() - 1 - age) % depth();
      Vector& q = q_[rank];
      q = df_[c];
      const Scalar before = std::sqrt(inner(q, q));
      for (std::size_t j = 0; j < rank; ++j) {
        R[j][rank] = inner(q_[j], q);
        q -= R[j][rank] * q_[j];
      }
      const Scalar left = std::sqrt(inner(q, q));
      if (!(left > static_cast<Scalar>(1e-6) * before)) continue;
      R[rank][rank] = left;
      q /= left;
      theta[rank] = inner(q, f);
      column[rank] = c;
      ++rank;
    }
    for (std::size_t k = rank; k-- > 0;) {
      for (std::size_t j = k + 1; j < rank; ++j) theta[k] -= R[k][j] * theta[j];
      theta[k] /= R[k][k];
      w -= theta[k] * dg_[column[k]];
    }
  }

 private:
  [[nodiscard]] std::size_t depth() const { return static_cast<std::size_t>(depth_); }

  Vector last_f_, last_g_;
  std::array<Vector, max_depth> df_, dg_, q_;  // the last ones, in a ring
  int depth_ = 0;
  std::size_t used_ = 0, next_ = 0;
  bool has_last_ = false, stretches_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
