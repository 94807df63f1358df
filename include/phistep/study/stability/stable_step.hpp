/// @file
/// The longest Δt for which a scheme keeps bounded every mode of a linearized problem that doesn't grow by itself.
///
/// With terms at φ = 0 as half kicks around an inner scheme of φ = ½ (schemes/kicks.hpp), positions obey
/// (M + ¼Δt²K_s)(r⁺−2r+r⁻)/Δt² + C (r⁺−r⁻)/2Δt = −(K_s+K_e) r: a central difference, stable where Δt²K_e < 4M, whatever K_s.
///
/// How long an outer step may be that calls slow terms once in k inner steps (schemes/kicks.hpp), of a linearized problem.
///
/// With M = 1, the fast forces −A r and the slow ones −B r, A and B symmetric, and T, S the inner steps' cos and sin,
///
///     T = cos kφ,   S = (h/sin φ) sin kφ,   sin(φ/2) = ½h√A,   h = Δt/k,                                          (1)
///     r⁺ + r⁻ = 2 (T − ½Δt S B) r     for the positions at the ends of outer steps                              (2)
///
/// where S > 0, T − ½Δt S B has the eigenvalues of the symmetric T − ½Δt S^½ B S^½, and nothing grows while they lie in (−1, 1).
/// They exceed −1 where ½ΔtB < S⁻¹(1+T), that is, as S⁻¹(1+T) falls with A: as long as, with the largest eigenvalues a of A
/// and b of B,
///
///     kφ < π   and   ½Δt b < cot(½kφ) sin(φ)/h,   sin(φ/2) = ½h√a;                                               (3)
///
/// and 1 isn't exceeded where A + B > 0, that is, where the exact solution doesn't grow. k = 1 is velocity Verlet, Δt²(a+b) < 4;
/// k → ∞ and b → 0 is Δt√a < π, half a period of the fastest motion in an outer step. Euler's two symplectic schemes are conjugate
/// to Verlet, and so have the same limit.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

#include "phistep/study/stability/method.hpp"
#include "phistep/study/stability/spectrum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// (3): Δt up to which no mode grows that doesn't by itself. [time]
/// @param a, b  largest ω² of the fast and of the slow terms [1/time²]
/// @param k     ≥ 1 inner steps
[[nodiscard]] inline double outer_step_limit(double a, double b, int k) {
  if (!(a > 0)) return b > 0 ? 2 / std::sqrt(b) : std::numeric_limits<double>::infinity();
  const double omega = std::sqrt(a);
  const double longest = 2 * k * std::sin(std::numbers::pi / (2 * k)) / omega;  // kφ = π
  if (!(b > 0)) return longest;
  return last_that_holds(0, longest, 60, [&](double dt) {
    const double h = dt / k, phi = 2 * std::asin(std::min(1.0, h * omega / 2));
    return dt / 2 * b * std::tan(k * phi / 2) < std::sin(phi) / h;
  });
}
/// The most inner steps of length h that an outer step may have; 0 where one is too many already.
[[nodiscard]] inline int most_inner_steps(double a, double b, double h) {
  const auto holds = [&](double k) {
    return k < 1 || std::floor(k) * h <= outer_step_limit(a, b, static_cast<int>(k));
  };
  int high = 1;
  for (; holds(high); high *= 2)
    if (high > 1 << 20) return high;
  return static_cast<int>(last_that_holds(high / 2, high, 30, holds));
}

/// The matrix of one outer step: kicks.hpp's loop, of matrices of any size.
/// @param fast   fast(h): the matrix of an inner step
/// @param slow   slow(j, γ): the matrix of a kick of slow term j
/// @param every  k of each of these
/// @param begin  weight of a kick at the beginning of its k inner steps, 1 − φ
template <class Matrix>
[[nodiscard]] Matrix outer_step_matrix(double dt, const std::vector<int>& every, double begin, auto&& fast,
                                       auto&& slow) {
  const int steps = *std::max_element(every.begin(), every.end());
  const double h = dt / steps;
  const Matrix inner = fast(h);
  Matrix G = inner;
  G.setIdentity();
  const auto kick = [&](int i, double weight) {
    for (std::size_t j = 0; j < every.size(); ++j)
      if (i % every[j] == 0 && weight != 0) G = (slow(j, weight * every[j] * h) * G).eval();
  };
  for (int i = 0; i < steps; ++i) {
    kick(i, begin);
    G = (inner * G).eval();
    kick(i + 1, 1 - begin);
  }
  return G;
}

/// A force linearized at a state: what is treated by the scheme itself, and what enters as kicks.
struct LinearizedProblem {
  Tangent whole, rest, kicks;
  PreflightMasses masses;
  int block = 0;         ///< rows of a particle, 0: unknown
  double tolerance = 0;  ///< of symmetry: what differences leave of it
  bool has_kicks = false;
  /// Terms called once in k inner steps, and the scheme of these; `rest` is then what each inner step calls.
  struct Slow {
    Tangent tangent;
    int k;
  };
  std::vector<Slow> slow{};
  Method inner{};

  [[nodiscard]] std::vector<int> every() const {
    std::vector<int> all;
    for (const Slow& one : slow) all.push_back(one.k);
    return all;
  }
  /// Weight of a slow kick at the beginning of its inner steps.
  [[nodiscard]] double begin_weight() const { return inner.kind == Method::Kind::verlet ? 0.5 : 1 - inner.force; }
};

/// Up to this size the matrix of a step is computed for many Δt.
inline constexpr Eigen::Index step_matrix_limit = 120;

template <class = void>
[[nodiscard]] Eigen::MatrixXd kick_matrix(const DenseSystemMatrices& kicks, double gamma) {
  // y + γ f(y + ½γ f(y)), f moving u alone
  Eigen::MatrixXd f = kicks.whole();
  f.topRows(kicks.K.cols()).setZero();
  const auto I = Eigen::MatrixXd::Identity(f.rows(), f.cols());
  return I + gamma * f * (I + gamma / 2 * f);
}

/// By the spectral radius of the step's own matrix: Δt grows until it exceeds what the exact solution grows by.
/// @param step_of  the matrix of a step of length h
/// @param longest  [time] not beyond
template <class = void>
[[nodiscard]] double scan_for_stable_step(const Spectrum& whole, double longest, auto&& step_of) {
  const auto stable = [&](double h) {
    const Eigen::MatrixXd G = step_of(h);
    if (!G.allFinite()) return false;
    double radius = 0;
    for (const auto lambda : eigenvalues_of(G)) radius = std::max(radius, std::abs(lambda));
    // A double zero, two positions that move freely, comes out as 1 ± √u.
    return radius <= std::exp(h * whole.growth) * (1 + 1e-6);
  };
  double low = std::min(0.02 / whole.radius, longest), high = low;
  if (!stable(low)) return 0;
  for (const double factor = std::isinf(longest) ? 1.2 : 1.05; stable(high); high = std::min(factor * high, longest)) {
    low = high;
    if (high >= longest) return longest;
    if (high * whole.radius > 1e4) return std::numeric_limits<double>::infinity();
  }
  return last_that_holds(low, high, 12, stable);
}
template <class = void>
[[nodiscard]] double scan_for_stable_step(const Method& method, const LinearizedProblem& problem,
                                          const Spectrum& whole) {
  DenseSystemMatrices rest = divided(problem.rest, problem.masses), kicks = rest;
  rest.balance();
  if (problem.has_kicks) kicks = divided(problem.kicks, problem.masses).in_units_of(rest);
  return scan_for_stable_step(whole, std::numeric_limits<double>::infinity(), [&](double h) -> Eigen::MatrixXd {
    const Eigen::MatrixXd G = step_matrix(method, rest, h);
    if (!problem.has_kicks) return G;
    const Eigen::MatrixXd kick = kick_matrix(kicks, h / 2);
    return kick * G * kick;
  });
}

/// For slow terms, called once in k inner steps: by (3) for one k, else by the step's matrix, as far as
/// (3) goes with all but the slowest for the fast ones: windows of growth, at resonances, begin there. NaN: nothing is guaranteed.
template <class = void>
[[nodiscard]] double stable_outer_step(const LinearizedProblem& problem, const Spectrum& whole) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  const std::vector<int> every = problem.every();
  const int steps = *std::max_element(every.begin(), every.end());
  const auto spectrum = [&](const Tangent& tangent) {
    return spectrum_of(tangent, problem.masses, problem.block, problem.tolerance);
  };
  Tangent faster = problem.rest, slowest{SparseRows(faster.K.rows(), faster.K.cols()), faster.C};
  for (const LinearizedProblem::Slow& one : problem.slow) {
    Tangent& to = one.k == steps ? slowest : faster;
    to.K += one.tangent.K;
    to.known = to.known && one.tangent.known;
  }
  const bool one_level = std::all_of(every.begin(), every.end(), [steps](int k) { return k == steps; });
  const Spectrum a = spectrum(faster), b = spectrum({slowest.K, SparseRows(slowest.C.rows(), slowest.C.cols())});
  if (!whole.bounded || !a.bounded || !b.bounded) return unknown;
  if (one_level && a.oscillates && b.oscillates && !a.has_C) return outer_step_limit(a.stiffness, b.stiffness, steps);
  if (!whole.exact || problem.whole.K.cols() + problem.whole.C.rows() > step_matrix_limit) return unknown;
  DenseSystemMatrices rest = divided(problem.rest, problem.masses);
  rest.balance();
  std::vector<DenseSystemMatrices> slow;
  for (const LinearizedProblem::Slow& one : problem.slow)
    slow.push_back(divided(one.tangent, problem.masses).in_units_of(rest));
  return scan_for_stable_step(
      whole, outer_step_limit(a.stiffness, b.stiffness, steps), [&](double dt) -> Eigen::MatrixXd {
        return outer_step_matrix<Eigen::MatrixXd>(
            dt, every, problem.begin_weight(), [&](double h) { return step_matrix(problem.inner, rest, h); },
            [&](std::size_t j, double gamma) { return kick_matrix(slow[j], gamma); });
      });
}

/// Without kicks. NaN: nothing is guaranteed. 0: never.
template <class = void>
[[nodiscard]] double stable_step_of(const Method& method, const LinearizedProblem& problem, const Spectrum& s) {
  constexpr double always = std::numeric_limits<double>::infinity(), unknown = std::numeric_limits<double>::quiet_NaN();
  const bool motion = problem.whole.K.cols() > 0;
  if (method.is_a_stable()) return always;
  if (!s.bounded) return unknown;
  if (s.radius == 0) return always;
  if (method.is_single()) {
    if (s.exact) {
      double dt = always;
      for (const auto lambda : s.eigenvalues) {
        const double size = std::abs(lambda);
        if (size <= (motion ? 1e-6 : 1e-10) * s.radius || lambda.real() > 1e-10 * size) continue;
        const bool oscillates = lambda.real() >= -1e-9 * size;
        dt = std::min(dt, oscillates ? method.oscillation_limit() / size : method.decay_limit(lambda));
      }
      return dt;
    }
    if (method.kind == Method::Kind::rational) {
      if (motion && !s.has_C && s.oscillates) return method.oscillation_limit() / std::sqrt(s.stiffness);
      return !motion && s.real_decay > 0 && s.up == 0 ? method.decay_limit(-s.real_decay) : unknown;
    }
    const double width = 1 - 2 * method.force;
    if (motion) {
      // λ² + cλ + ω² = 0 with c and ω² between their bounds: −2 Re λ/|λ|² = c/ω², or 2/|λ| ≥ 2/c.
      if (!s.has_C) return s.oscillates ? 0 : unknown;
      if (!s.oscillates || !s.dissipative || s.up > 0 || s.least_damping == 0) return unknown;
      return std::min(s.least_damping / s.stiffness, 2 / s.damping) / width;
    }
    double worst = always;
    if (s.real_decay >= 0) worst = s.real_decay;
    if (s.right > 0) worst = std::min(worst, std::max(s.left + s.up * s.up / s.left, s.right + s.up * s.up / s.right));
    return worst < always ? 2 / (width * worst) : unknown;
  }
  if (!s.has_C && s.oscillates) {
    const double limit = method.oscillation_limit();
    return limit == 0 ? 0 : s.stiffness == 0 ? always : limit / std::sqrt(s.stiffness);
  }
  if (method.kind == Method::Kind::motion) {
    // Newmark's family: no symmetric damping shortens the stable step (T. J. R. Hughes, The Finite Element Method, 2000, sect. 9.1.2).
    if (!method.bears_damping || !s.oscillates || !s.dissipative || !is_symmetric(problem.whole.C, problem.tolerance))
      return unknown;
    return s.stiffness == 0 ? always : method.oscillation_limit() / std::sqrt(s.stiffness);
  }
  if (s.exact && problem.whole.K.cols() + problem.whole.C.rows() <= step_matrix_limit)
    return scan_for_stable_step(method, problem, s);
  if (!s.oscillates || !s.dissipative) return unknown;
  if (method.kind == Method::Kind::verlet) return 2 / std::sqrt(s.stiffness);
  if (s.up > 0) return unknown;  // a mass that isn't symmetric: gyroscopic forces do drive these two
  if (method.force == 1 && method.drift == 0) return 2 / std::sqrt(s.stiffness);
  if (method.force == 0 && method.drift == 1)
    return 4 / (s.damping + std::sqrt(s.damping * s.damping + 4 * s.stiffness));
  return unknown;
}

template <class = void>
[[nodiscard]] double stable_step(const Method& method, const LinearizedProblem& problem, const Spectrum& whole) {
  if (!problem.slow.empty()) return stable_outer_step(problem, whole);
  if (!problem.has_kicks || problem.kicks.is_zero()) return stable_step_of(method, problem, whole);
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  if (!whole.bounded) return unknown;
  const bool half = method.kind == Method::Kind::single && method.force == 0.5;
  const Spectrum kicks = spectrum_of(problem.kicks, problem.masses, problem.block, problem.tolerance);
  if (half && whole.oscillates && whole.dissipative && !kicks.has_C && kicks.bounded && kicks.oscillates)
    return 2 / std::sqrt(kicks.stiffness);
  if (method.kind == Method::Kind::rational || method.kind == Method::Kind::motion) return unknown;
  if (whole.exact && problem.whole.K.cols() + problem.whole.C.rows() <= step_matrix_limit)
    return scan_for_stable_step(method, problem, whole);
  return unknown;
}

}}  // namespace phistep::PHISTEP_ABI
