#pragma once

// What rounding may do to a step on y' = λy: each scheme's own operations on numbers that carry their bounds (rounded.hpp).
// What a solve returns is not what its formula does, but what its equation allows: Newton's iteration ends where γλY − w is
// rounding, w = Y − b, and that is off by the same times 1/(1 − γλ).

#include <phistep/phistep.hpp>

#include <complex>
#include <cstddef>
#include <vector>

#include "accuracy/stability/rounded.hpp"
#include "accuracy/stability/theory.hpp"

namespace stability::models {

using Number = Rounded<Complex>;

/// How the step's equation is solved: by iteration to rounding, or by one correction of the start, which for motion is v, or
/// the better of r and v.
enum class Solve { iterated, once, once_from_v };

struct Resolved {
  Number Y, w;
};
/// Y = b + ζ Y
[[nodiscard]] inline Resolved resolve(const Number& b, const Number& guess, const Number& zeta, Solve how) {
  const Complex one_minus = Complex{1} - zeta.x;
  if (how != Solve::iterated) {
    const Number start{guess.x}, w0 = start - b;
    const Number delta = solved(Number{1} - zeta, zeta * start - w0);
    return {start + delta, w0 + delta};
  }
  const Complex Y = b.x / one_minus, w = zeta.x * Y;
  // λY, times γ, the rounding of w and of γλY − w.
  const Real residual = zeta.e * std::abs(Y) + (product_cost<Complex> + 4) * std::abs(w);
  const Real peak = std::max({b.peak, zeta.peak, std::abs(w)});
  return {{Y, (b.e + residual) / std::abs(one_minus) + 3 * std::abs(Y), peak},
          {w, (std::abs(zeta.x) * b.e + residual) / std::abs(one_minus) + 2 * std::abs(w), peak}};
}

[[nodiscard]] inline Number phi_endpoint(const Number& y, const Number& z, Real phi, Solve how) {
  const Number b = phi == 1 ? y : y + scaled(1 - phi, z * y);
  return phi == 0 ? b : resolve(b, y, scaled(phi, z), how).Y;
}
[[nodiscard]] inline Number phi_stage(const Number& y, const Number& z, Real phi, Solve how) {
  if (phi == 0) return phi_endpoint(y, z, 0, how);
  const Resolved stage = resolve(y, y, scaled(phi, z), how);
  return stage.Y + scaled((1 - phi) / phi, stage.w);
}
/// By fixed-point iterations, which end at the latest where the residual no longer falls and its largest component is below
/// the plateau (2u)^⅔ of Y, y, b and the first residual zy (step/solve/fixed_point.hpp).
[[nodiscard]] inline Number phi_by_iteration(const Number& y, const Number& z, Real phi) {
  Number out = phi_endpoint(y, z, phi, Solve::iterated);
  const Number b = y + scaled(1 - phi, z * y);
  out.e += std::sqrt(Real{2}) * std::pow(2 * unit_roundoff, Real{2} / 3) / unit_roundoff *
           std::max({out.size(), y.size(), b.size(), std::abs(z.x) * y.size()}) /
           std::abs(Complex{1} - Complex{phi} * z.x);
  return out;
}
/// Half of the time by the explicit midpoint rule, before and after a φ-step of the other half of Ψ.
[[nodiscard]] inline Number split(const Number& y, const Number& z, Real phi) {
  const Number half = scaled(0.5L, z);
  const auto kick = [&half](const Number& x) { return x + scaled(0.5L, half * (x + scaled(0.25L, half * x))); };
  const Number kicked = kick(y);
  return kick(phi_endpoint(kicked, half, phi, Solve::iterated));
}
[[nodiscard]] inline Number tr_bdf2(const Number& y, const Number& z, Solve how) {
  const Real gamma = 2 - std::sqrt(Real{2}), beta = (1 + std::sqrt(Real{2})) / 2;
  Number a = scaled(gamma / 2, z);
  a.e += 2 * std::abs(a.x);  // √2 is off by u, and 2 − √2 so by 2u of itself
  const Number Y = resolve(y + scaled(gamma / 2, z * y), y, a, how).Y;
  return resolve(y + scaled(beta, Y - y), Y, a, how).Y;
}
[[nodiscard]] inline Number two_halves(const Number& y, const Number& z, Solve how) {
  const Number half = scaled(0.5L, z), middle = resolve(y, y, half, how).Y;
  // From y, which may be far away, the iteration ends where its corrections are rounding beside b.
  Number out = resolve(middle, y, half, how).Y;
  out.e += 2 * middle.size();
  return out;
}
[[nodiscard]] inline Number composed_trapezoidal(Number y, const Number& z, Solve how) {
  for (const Real share : theory::kahan_li()) y = phi_endpoint(y, scaled(share, z), 0.5L, how);
  return y;
}

template <class Tableau>
[[nodiscard]] Number explicit_rk(const Number& y, const Number& z) {
  std::vector<Number> k;
  for (std::size_t i = 0;; ++i) {
    Number moved{0};
    for (std::size_t j = 0; j < i; ++j)
      if (Tableau::a[i][j] != 0) moved = moved + scaled(Tableau::a[i][j], k[j]);
    const Number Y = y + moved;
    if (i == Tableau::end) return Y;
    k.push_back(z * Y);
  }
}

/// A coefficient printed with sixteen digits: half a unit of the last is at most 5e-16 = 4.5 u of it.
[[nodiscard]] inline Number published(Real coefficient, const Number& x) {
  Number out = scaled(coefficient, x);
  out.e += 4.5L * std::abs(out.x);
  return out;
}
template <class Tableau>
[[nodiscard]] Number rosenbrock(const Number& y, const Number& z) {
  const Number W = Number{1} - published(Tableau::gamma, z);
  std::vector<Number> u;
  Number Y = y;
  for (std::size_t i = 0; i < Tableau::stages; ++i) {
    Y = y;
    Number weighted{0};
    for (std::size_t j = 0; j < i; ++j) {
      if (Tableau::a[i][j] != 0) Y = Y + published(Tableau::a[i][j], u[j]);
      if (Tableau::c[i][j] != 0) weighted = weighted + published(Tableau::c[i][j], u[j]);
    }
    u.push_back(solved(W, published(Tableau::gamma, z * Y) + published(Tableau::gamma, weighted)));
  }
  return Y + u.back();
}

/// Simplified Newton iterations on w = T⁻¹Z, A⁻¹ = T diag(1/μ) T⁻¹: ends where what rounding leaves of
/// z T⁻¹(y + Z) − w/μ, divided by 1/μ − z. The matrix 1/μ − hJ of a lane has the eigenvalues 1/μ − z and 1/μ − z̄.
template <int s>
[[nodiscard]] Number radau(const Complex& z) {
  const auto& tableau = phistep::radau_tableau<s>;
  constexpr std::size_t lanes = (s + 1) / 2, n = s;
  const auto magnitude = [](auto c) { return std::hypot(static_cast<Real>(c.re), static_cast<Real>(c.im)); };
  std::array<Real, lanes> w{}, nearest{}, nu{};
  for (std::size_t l = 0; l < lanes; ++l) {
    const Complex inverse = Complex{1} / Complex{tableau.mu[l].re, tableau.mu[l].im};
    Complex g{0};
    for (std::size_t j = 0; j < n; ++j) g += Complex{tableau.T_inverse[l][j].re, tableau.T_inverse[l][j].im};
    nearest[l] = std::min(std::abs(inverse - z), std::abs(inverse - std::conj(z)));
    nu[l] = std::abs(inverse);
    w[l] = std::abs(z) * std::abs(g) / nearest[l];
  }
  std::array<Real, n> moved{};
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t l = 0; l < lanes; ++l) moved[j] += magnitude(tableau.T[j][l]) * w[l];
  Real error = 0, peak = std::abs(z);
  for (std::size_t l = 0; l < lanes; ++l) {
    Real residual = 4 * nu[l] * w[l];
    for (std::size_t j = 0; j < n; ++j)
      residual += magnitude(tableau.T_inverse[l][j]) * std::abs(z) *
                  ((product_cost<Complex> + 2 + s) * (1 + moved[j]) + (s + 2) * moved[j]);
    // Twice: the last correction may be as large as what it leaves.
    error += magnitude(tableau.T[n - 1][l]) * (2 * residual / nearest[l] + (s + 4) * w[l]);
    peak = std::max(peak, w[l]);
  }
  const Complex R = theory::radau(z, s);
  return {R, error + std::abs(R) + 1, peak};
}

}  // namespace stability::models
