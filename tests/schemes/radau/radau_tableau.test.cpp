// The coefficients made at compile time: the conditions that define Radau IIA, in long double.
#include <phistep/schemes/radau/radau_tableau.hpp>

#include <cmath>
#include <complex>

#include "support/catch.hpp"

using namespace phistep;
using Real = long double;
using Complex = std::complex<Real>;

namespace {

Complex number(radau_detail::Complex z) { return {z.re, z.im}; }
/// a_ij of A = T diag(μ) T⁻¹
template <int s>
Real a(std::size_t i, std::size_t j) {
  const auto& t = radau_tableau<s>;
  Complex sum = 0;
  for (std::size_t l = 0; l < t.lanes; ++l) sum += number(t.mu[l]) * number(t.T[i][l]) * number(t.T_inverse[l][j]);
  return sum.real();
}
/// Rounding of one long double operation on numbers of order 1. x87's is 5.4e-20; where long double is double, that.
constexpr Real u = std::numeric_limits<Real>::epsilon();

template <int s>
void check() {
  CAPTURE(s);
  static constexpr const auto& t = radau_tableau<s>;  // a constant expression
  static_assert(t.c[s - 1] == 1);
  Real quadrature = 0, stiffly = 0, collocation = 0, inverse = 0, expansion = 0;
  for (int k = 1; k < 2 * s; ++k) {  // B(2s−1): the order is 2s−1
    Real sum = 0;
    for (std::size_t j = 0; j < s; ++j) sum += t.b[j] * std::pow(t.c[j], Real(k - 1));
    quadrature = std::max(quadrature, std::abs(sum - 1 / Real(k)));
  }
  {  // and not 2s
    Real sum = 0;
    for (std::size_t j = 0; j < s; ++j) sum += t.b[j] * std::pow(t.c[j], Real(2 * s - 1));
    CHECK(std::abs(sum - 1 / Real(2 * s)) > 1e-9L);
  }
  for (std::size_t i = 0; i < s; ++i) {
    stiffly = std::max(stiffly, std::abs(a<s>(s - 1, i) - t.b[i]));
    for (int k = 1; k <= s; ++k) {  // C(s): it is the collocation method
      Real sum = 0;
      for (std::size_t j = 0; j < s; ++j) sum += a<s>(i, j) * std::pow(t.c[j], Real(k - 1));
      collocation = std::max(collocation, std::abs(sum - std::pow(t.c[i], Real(k)) / Real(k)));
    }
    for (std::size_t j = 0; j < s; ++j) {  // 1 = T T⁻¹: real parts, of one lane a pair
      Complex one = 0;
      for (std::size_t l = 0; l < t.lanes; ++l) one += number(t.T[i][l]) * number(t.T_inverse[l][j]);
      inverse = std::max(inverse, std::abs(one.real() - (i == j ? 1 : 0)));
    }
  }
  // The polynomial through z_j = c_jᵏ is xᵏ = Σ_m binom(k, m) (x − 1)ᵐ.
  for (int k = 1; k <= s; ++k) {
    Real binomial = 1;
    for (std::size_t m = 0; m < s; ++m) {
      Complex a = 0;
      for (std::size_t l = 0; l < t.lanes; ++l) {
        Complex w = 0;
        for (std::size_t j = 0; j < s; ++j) w += std::pow(t.c[j], Real(k)) * number(t.T_inverse[l][j]);
        a += number(t.taylor[m][l]) * w;
      }
      binomial *= Real(k - static_cast<int>(m)) / Real(m + 1);
      expansion = std::max(expansion, std::abs(a.real() - binomial));
    }
  }
  CHECK(quadrature <= 8 * u);
  // Rounding moves an eigenvector by u κ/distance of the eigenvalues, which enters T T⁻¹ with another κ (Golub & Van Loan,
  // Matrix Computations, sect. 7.2.4): 1e7 u for 7 stages.
  Real condition = 1, distance = 1;
  for (std::size_t l = 0; l < t.lanes; ++l) {
    Real left = 0, right = 0;
    for (std::size_t i = 0; i < s; ++i) {
      right = std::max(right, std::abs(number(t.T[i][l])));
      left += std::abs(number(t.T_inverse[l][i]));
    }
    condition = std::max(condition, left * right);
    for (std::size_t k = 0; k < l; ++k) distance = std::min(distance, std::abs(number(t.mu[l]) - number(t.mu[k])));
  }
  const Real growth = condition * condition / distance;
  CAPTURE(condition, distance);
  CHECK(stiffly <= growth * u);
  CHECK(collocation <= growth * u);
  CHECK(inverse <= growth * u);
  CHECK(expansion <= 40 * growth * u);  // binomials reach 35
  for (std::size_t l = 0; l < t.lanes; ++l) {
    CHECK((l == 0 ? t.mu[l].im == 0 : t.mu[l].im > 0));
    CHECK(t.mu[l].re > 0);
    CHECK(std::abs(number(t.T[s - 1][l]) - Complex{1}) <= 8 * u);
  }
}

}  // namespace

TEST_CASE("order, stage order, stiff accuracy and transformation of 3, 5 and 7 stages") {
  check<3>();
  check<5>();
  check<7>();
}

TEST_CASE("three stages are the published ones (HW II, table IV.5.6)") {
  const auto& t = radau_tableau<3>;
  const Real r = std::sqrt(6.0L);
  CHECK(std::abs(t.c[0] - (4 - r) / 10) <= 4 * u);
  CHECK(std::abs(t.c[1] - (4 + r) / 10) <= 4 * u);
  CHECK(std::abs(a<3>(0, 0) - (88 - 7 * r) / 360) <= 4 * u);
  CHECK(std::abs(a<3>(0, 1) - (296 - 169 * r) / 1800) <= 4 * u);
  CHECK(std::abs(a<3>(1, 2) - (-2 - 3 * r) / 225) <= 4 * u);
  CHECK(std::abs(t.b[0] - (16 - r) / 36) <= 4 * u);
  CHECK(std::abs(t.b[2] - 1 / 9.0L) <= 4 * u);
  // γ̂ = 1/λ₀, λ₀ = 3 + ∛9 − ∛3 … of A⁻¹: HW II p. 122 gives (6 + ∛81 − ∛9)/30.
  CHECK(std::abs(t.mu[0].re - (6 + std::cbrt(81.0L) - std::cbrt(9.0L)) / 30) <= 4 * u);
}
