#pragma once

// Stability functions R(z), y⁺ = R(λΔt) y, written down from the literature and without the library, in extended precision.
// Z is a complex number; for motion, the matrix [[0, 1], [−a², −2ζa]] as an element of its own algebra (motion.hpp).

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "accuracy/stability/rounded.hpp"

namespace stability::theory {

/// Hairer & Wanner, Solving ODEs II, IV.3: the θ-method.
template <class Z>
[[nodiscard]] Z phi(const Z& z, Real phi) {
  return (Z(1) + Z(1 - phi) * z) / (Z(1) - Z(phi) * z);
}

/// Strang's splitting of z into halves: the explicit midpoint rule over Δt/2, the θ-method, the midpoint rule again.
template <class Z>
[[nodiscard]] Z split(const Z& z, Real weight) {
  const Z half = Z(0.5L) * z, kick = Z(1) + Z(0.5L) * half + Z(0.125L) * half * half;
  return kick * phi(half, weight) * kick;
}

/// Bank et al. (1985): the trapezoidal rule to γ, then BDF2 through 0, γ and 1.
template <class Z>
[[nodiscard]] Z tr_bdf2(const Z& z) {
  const Real g = 2 - std::sqrt(Real{2});
  const Z middle = (Z(1) + Z(g / 2) * z) / (Z(1) - Z(g / 2) * z);
  return (middle - Z((1 - g) * (1 - g))) / (Z(g * (2 - g)) * (Z(1) - Z((1 - g) / (2 - g)) * z));
}

/// Rannacher's first step: two backward Euler half steps.
template <class Z>
[[nodiscard]] Z two_halves(const Z& z) {
  const Z half = Z(1) / (Z(1) - Z(0.5L) * z);
  return half * half;
}

template <class Z>
[[nodiscard]] Z horner(const std::vector<Real>& coefficients, const Z& z) {
  Z sum(0);
  for (std::size_t k = coefficients.size(); k-- > 0;) sum = sum * z + Z(coefficients[k]);
  return sum;
}

/// Σ p_k z^k / (1 − γz)^s: a stiffly accurate Rosenbrock method. To its order on y' = λy, p is that of e^z (1 − γz)^s
/// (HW II, IV.3 and IV.7); the one that is left follows from the published coefficients, by algebra in 30 digits.
struct RosenbrockTheory {
  int stages, linear_order;
  Real gamma, last;
  [[nodiscard]] std::vector<Real> numerator() const {
    std::vector<Real> p;
    for (int k = 0; k <= linear_order; ++k) {
      Real sum = 0, binomial = 1;
      for (int i = 0; i <= k; ++i) {
        sum += binomial * std::pow(-gamma, static_cast<Real>(i)) / std::tgamma(static_cast<Real>(k - i + 1));
        binomial *= static_cast<Real>(stages - i) / static_cast<Real>(i + 1);
      }
      p.push_back(sum);
    }
    p.push_back(last);
    return p;
  }
  template <class Z>
  [[nodiscard]] Z operator()(const Z& z) const {
    // In w = 1/(1 − γz), z = (1 − 1/w)/γ: nothing overflows, nothing cancels at infinity.
    const Z w = Z(1) / (Z(1) - Z(gamma) * z), zw = z * w;
    const std::vector<Real> p = numerator();
    Z sum(0), power = w;
    for (std::size_t k = p.size(); k < static_cast<std::size_t>(stages); ++k) power = power * w;
    // Σ p_k (zw)^k w^(s−k)
    for (std::size_t k = p.size(); k-- > 0;) {
      Z term = power * Z(p[k]);
      for (std::size_t i = 0; i < k; ++i) term = term * zw;
      sum = sum + term;
      power = power * w;
    }
    return sum;
  }
};
inline const RosenbrockTheory rodas4{6, 4, 0.25L, -0.0021586548062599795L};
inline const RosenbrockTheory rodas5p{8, 6, 0.21193756319429014L, 5.0968102282043367e-5L};

/// Radau IIA of s stages: Padé's approximation of e^z with degrees s − 1 and s (HW II, IV.3, eq. 3.30 and IV.5).
template <class Z>
[[nodiscard]] Z radau(const Z& z, int stages) {
  const auto coefficients = [](int k, int j, int degree) {
    // of z^degree in the numerator of Padé (k, j)
    Real c = 1;
    for (int i = 0; i < degree; ++i) c *= static_cast<Real>(k - i) / static_cast<Real>((i + 1) * (j + k - i));
    return c;
  };
  const int s = stages;
  std::vector<Real> p, q;
  for (int i = 0; i <= s - 1; ++i) p.push_back(coefficients(s - 1, s, i));
  for (int i = 0; i <= s; ++i) q.push_back((i % 2 == 0 ? 1 : -1) * coefficients(s, s - 1, i));
  return horner(p, z) / horner(q, z);
}

/// HW II, IV.2: of an explicit Runge-Kutta tableau, stage by stage.
template <class Tableau, class Z>
[[nodiscard]] Z explicit_rk(const Z& z) {
  std::vector<Z> k;
  for (std::size_t i = 0; i <= Tableau::end; ++i) {
    Z Y(1);
    for (std::size_t j = 0; j < i; ++j)
      if (Tableau::a[i][j] != 0) Y = Y + Z(Tableau::a[i][j]) * k[j];
    if (i == Tableau::end) return Y;
    k.push_back(z * Y);
  }
  return Z(0);
}

/// W. Kahan & R.-C. Li, Math. Comp. 66 (1997) 1089: seventeen symmetric substeps of order 8.
[[nodiscard]] inline std::array<Real, 17> kahan_li() {
  constexpr Real half[] = {.13020248308889008088L, .56116298177510838456L,  -.38947496264484728641L,
                           .15884190655515560090L, -.39590389413323757734L, .18453964097831570709L,
                           .25837438768632204729L, .29501172360931029887L};
  std::array<Real, 17> all{};
  Real sum = 0;
  for (std::size_t i = 0; i < 8; ++i) all[i] = all[16 - i] = half[i], sum += half[i];
  all[8] = 1 - 2 * sum;
  return all;
}
template <class Z>
[[nodiscard]] Z composed_trapezoidal(const Z& z) {
  Z product(1);
  for (const Real share : kahan_li()) product = product * phi(Z(share) * z, 0.5L);
  return product;
}

}  // namespace stability::theory
