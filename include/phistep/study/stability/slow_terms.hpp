/// @file
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

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The largest x found between `low`, where holds(x), and `high`, by so many bisections.
[[nodiscard]] double last_that_holds(double low, double high, int bisections, auto&& holds) {
  for (int k = 0; k < bisections; ++k) {
    const double middle = (low + high) / 2;
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

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
  int low = 0, high = 1;
  const auto holds = [&](int k) { return k * h <= outer_step_limit(a, b, k); };
  for (; holds(high); high *= 2) {
    low = high;
    if (high > 1 << 20) return high;
  }
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

/// The matrix of one outer step: kicks.hpp's loop, of matrices of any size.
/// @param fast   fast(h): the matrix of an inner step
/// @param slow   slow(j, γ): the matrix of a kick of slow term j
/// @param every  k of each of these
/// @param begin  weight of a kick at the beginning of its k inner steps, 1 − φ
template <class Matrix>
[[nodiscard]] Matrix outer_step_matrix(Matrix G, double dt, const std::vector<int>& every, double begin, auto&& fast,
                                       auto&& slow) {
  const int steps = *std::max_element(every.begin(), every.end());
  const double h = dt / steps;
  const Matrix inner = fast(h);
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

}}  // namespace phistep::PHISTEP_ABI
