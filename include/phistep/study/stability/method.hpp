/// @file
/// What a scheme does to a linear problem: the factor by which it multiplies a mode, and how long a step it bears.
///
///     R(z) = (1 + (1−φ) z)/(1 − φ z)                                    φ-step, first order or motion, z = λΔt          (1)
///     R(z) = (1 + √2 ζ)/(1 − ζ)²,  ζ = ½(2−√2) z                         TR-BDF2                                       (2)
///     (φ_f, φ_d), undamped:  d = 1 + φ_f φ_d a²,  tr = 2 − (φ_f+φ_d) a²/d,  det = 1 + (1−φ_f−φ_d) a²/d,  a = ωΔt       (3)
///
/// (1) is stable where 2 Re z + (1−2φ)|z|² ≤ 0; (3), tr and det being those of one step's 2×2 matrix, where φ_f+φ_d ≥ 1 and
/// a² (2φ_f−1)(1−2φ_d) < 4. Velocity Verlet is the central difference (r⁺−2r+r⁻)/Δt² + C w + K r = 0, w = (r⁺−r⁻)/2Δt. With
/// u = (r⁺−r)/Δt and r̄ = ½(r⁺+r), its energy ½uᵀ(1 − Δt²K/4)u + ½ r̄ᵀK r̄ falls by Δt wᵀC w a step: stable for ωΔt < 2 with any
/// C + Cᵀ ≥ 0. For (0, 1) and (1, 0) the mass in it is 1 ∓ ½ΔtC instead: ω²Δt² + 2cΔt < 4, and ωΔt < 2, for symmetric C ≥ 0.
///
/// R(z) of any other scheme, or its factor on an oscillation, is what its own step makes of y' = zy, or of r'' = −a²r. The end of
/// its stability is searched along a ray, in steps of a hundredth and less: where the growth exceeds 1e-9 a step.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

#include "phistep/base/facts/phi.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/schemes/phi.hpp"
#include "phistep/schemes/tr_bdf2.hpp"
#include "phistep/schemes/velocity_verlet.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The eigenvalue of larger modulus of a 2×2 matrix.
[[nodiscard]] inline std::complex<double> larger_eigenvalue(double trace, double det) {
  const double square = det - trace * trace / 4;
  if (square >= 0) return {trace / 2, std::sqrt(square)};
  return trace / 2 + std::copysign(std::sqrt(-square), trace);
}

/// The largest x found between `low`, where holds(x), and `high`, by so many bisections.
[[nodiscard]] double last_that_holds(double low, double high, int bisections, auto&& holds) {
  for (int k = 0; k < bisections; ++k) {
    const double middle = (low + high) / 2;
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

/// A scheme as numbers.
struct Method {
  enum class Kind {
    single,    ///< (1)
    pair,      ///< (3)
    verlet,    ///<
    rational,  ///< some other R(z), as (2)
    motion     ///< of a motion alone, known by what it does to an oscillation
  };
  Kind kind = Kind::single;
  double force = 0, drift = 0;  ///< φ_force and φ_drift; φ twice where there is one
  bool a_stable = false;        ///< `rational`: by proof
  std::function<std::complex<double>(std::complex<double>)> R{};  ///< `rational`
  std::function<std::complex<double>(double)> swing{};            ///< `motion`: the factor on an undamped oscillation
  bool bears_damping = false;  ///< `motion`: no symmetric damping shortens the step that it is stable to

  [[nodiscard]] bool is_single() const { return kind == Kind::single || kind == Kind::rational; }
  /// Stable for every mode that doesn't grow, at any Δt.
  [[nodiscard]] bool is_a_stable() const { return (kind == Kind::single && force >= 0.5) || a_stable; }

  /// The factor of one step on a mode e^{λt}, z = λΔt; for kinds with one R.
  [[nodiscard]] std::complex<double> factor(std::complex<double> z) const {
    if (R) return R(z);
    return (1.0 + (1 - force) * z) / (1.0 - force * z);
  }
  /// The factor of one step on an undamped oscillation, a = ωΔt.
  [[nodiscard]] std::complex<double> oscillation(double a) const {
    if (swing) return swing(a);
    if (is_single()) return factor({0, a});
    const double d = kind == Kind::verlet ? 1 : 1 + force * drift * a * a, s = kind == Kind::verlet ? 1 : force + drift;
    const double trace = 2 - s * a * a / d, det = 1 + (1 - s) * a * a / d;
    return larger_eigenvalue(trace, det);
  }
  /// ωΔt up to which an undamped oscillation stays bounded: infinite, or 0 for never.
  [[nodiscard]] double oscillation_limit() const {
    constexpr double always = std::numeric_limits<double>::infinity();
    if (kind == Kind::verlet) return 2;
    if (is_a_stable()) return always;
    if (kind == Kind::rational || kind == Kind::motion)
      return end_of([this](double a) {
        const std::complex<double> g = oscillation(a);
        // Where the phase of a step nears kπ a motion may have windows of growth, 3e-4 of ωΔt wide.
        const bool is_near = kind == Kind::motion && a > 1 && std::abs(g.real()) > 0.9;
        return std::pair{std::abs(g) <= 1 + growth, is_near ? 1.00005 : 1.01};
      });
    if (is_single()) return 0;
    if (force + drift < 1 - 1e-12) return 0;
    const double product = (2 * force - 1) * (1 - 2 * drift);
    return product > 0 ? 2 / std::sqrt(product) : always;
  }
  /// Δt up to which a mode e^{λt} that doesn't grow stays bounded; for kinds with one R.
  [[nodiscard]] double decay_limit(std::complex<double> lambda) const {
    if (is_a_stable()) return std::numeric_limits<double>::infinity();
    if (kind == Kind::rational) {
      const double size = std::abs(lambda);
      return end_of([&](double x) { return std::pair{std::abs(R(x / size * lambda)) <= 1 + growth, 1.01}; }) / size;
    }
    return std::max(0.0, -2 * lambda.real()) / ((1 - 2 * force) * std::norm(lambda));
  }
  /// Relative error of the exponent that a step gives to e^{λt}: that of the period (real part) and, for oscillations, the
  /// damping ratio that the scheme adds (imaginary part).
  [[nodiscard]] std::complex<double> exponent_error(std::complex<double> z) const {
    const bool oscillates = z.real() == 0 && z.imag() != 0;
    const std::complex<double> g = oscillates ? oscillation(std::abs(z.imag())) : factor(z);
    const std::complex<double> e = oscillates ? std::complex<double>{0, std::abs(z.imag())} : z;
    if (g == 0.0) return std::numeric_limits<double>::infinity();
    return std::log(g) / e - 1.0;
  }
  /// The longest Δt whose exponent is off by at most `accuracy` for e^{λt}.
  [[nodiscard]] double accurate_dt(std::complex<double> lambda, double accuracy) const {
    const double size = std::abs(lambda);
    if (!(size > 0)) return std::numeric_limits<double>::infinity();
    const auto holds = [&](double a) { return std::abs(exponent_error(a / size * lambda)) <= accuracy; };
    return last_that_holds(0, 3, 60, holds) / size;
  }

  /// |z| on the negative real axis up to which R(z) is positive: no mode changes its sign from step to step.
  [[nodiscard]] double sign_limit() const {
    if (kind == Kind::rational) return end_of([this](double x) { return std::pair{R(-x).real() >= 0, 1.01}; });
    return 1 / (1 - force);
  }

 private:
  static constexpr double growth = 1e-9;  ///< without a formula: a step that grows by less counts as stable
  /// The largest x up to which test(x) → (whether it holds, factor to the next x) holds: 0, up to 1e4, or infinite.
  [[nodiscard]] static double end_of(auto&& test) {
    double low = 0, high = 0.02;
    for (auto [holds, factor] = test(high); holds; std::tie(holds, factor) = test(high)) {
      low = high;
      high *= factor;
      if (high > 1e4) return std::numeric_limits<double>::infinity();
    }
    if (low == 0) return 0;
    return last_that_holds(low, high, 30, [&](double x) { return test(x).first; });
  }
};

template <class Force, class Drift, Form form>
[[nodiscard]] Method method_of(const PhiScheme<Force, Drift, form>& scheme) {
  const double f = scheme.force.template value<double>(), d = scheme.drift.template value<double>();
  return {f == d ? Method::Kind::single : Method::Kind::pair, f, d};
}
[[nodiscard]] inline Method method_of(const VelocityVerlet&) { return {Method::Kind::verlet, 0.5, 0.5}; }
[[nodiscard]] inline Method method_of(const TrBdf2&) {
  return {Method::Kind::rational, 1, 1, true, [](std::complex<double> z) {
            const std::complex<double> zeta = 0.5 * (2 - std::numbers::sqrt2) * z;
            return (1.0 + std::numbers::sqrt2 * zeta) / ((1.0 - zeta) * (1.0 - zeta));
          }};
}
/// The trapezoidal rule, which follows its damping start.
[[nodiscard]] inline Method method_of(const Rannacher&) { return {Method::Kind::single, 0.5, 0.5}; }

/// r' = s u (its first components), u' = K r + C u, small and dense; r may be empty.
struct DenseSystemMatrices {
  Eigen::MatrixXd K, C;
  double s = 1;
  /// Measures r in other units, so that r' and u' come out alike: eigenvalues would drown in K otherwise. A power of two.
  void balance() {
    const double top = largest(K);
    if (!(top > 0)) return;
    s = std::exp2(std::floor(std::log2(top) / 2));
    K /= s;
  }
  [[nodiscard]] DenseSystemMatrices in_units_of(const DenseSystemMatrices& other) const {
    return {K / other.s, C, other.s};
  }
  /// (r, u)' = L (r, u)
  [[nodiscard]] Eigen::MatrixXd whole() const {
    const Eigen::Index p = K.cols(), n = C.cols();
    Eigen::MatrixXd L = Eigen::MatrixXd::Zero(p + n, p + n);
    L.topRightCorner(p, n).leftCols(p).diagonal().setConstant(s);
    L.bottomLeftCorner(n, p) = K;
    L.bottomRightCorner(n, n) = C;
    return L;
  }
};

/// The matrix of one step.
template <class = void>
[[nodiscard]] Eigen::MatrixXd step_matrix(const Method& method, const DenseSystemMatrices& system, double h) {
  const Eigen::MatrixXd L = system.whole();
  const Eigen::Index n = L.rows(), p = system.K.cols();
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(n, n);
  const auto solve = [](const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) -> Eigen::MatrixXd {
    return A.partialPivLu().solve(B);
  };
  // Rows of r take the weight of the drift, those of u that of the force.
  const auto weighted = [&](double drift, double force) {
    Eigen::MatrixXd W = L;
    W.topRows(p) *= drift;
    W.bottomRows(n - p) *= force;
    return W;
  };
  if (method.kind == Method::Kind::verlet) {
    // Kick, drift with the new velocity; then the last kick, u alone implicit.
    Eigen::MatrixXd drift = I + h * weighted(1, 0), last = I;
    last.bottomRightCorner(n - p, n - p) -= h / 2 * system.C;
    Eigen::MatrixXd pull = I;
    pull.bottomLeftCorner(n - p, p) += h / 2 * system.K;
    return solve(last, pull * drift * (I + h / 2 * weighted(0, 1)));
  }
  return solve(I - h * weighted(method.drift, method.force), I + h * weighted(1 - method.drift, 1 - method.force));
}

}}  // namespace phistep::PHISTEP_ABI
