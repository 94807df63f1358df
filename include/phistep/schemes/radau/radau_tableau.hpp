/// @file
/// Coefficients of the Radau IIA methods (Hairer & Wanner, Solving ODEs II, sect. IV.5), made at compile time from their nodes and
/// the eigenvalues μ of A, which stand here as x87 rounds them.
///
/// With P_k the Legendre polynomials, orthonormal on [0, 1], the nodes c_i are the zeros of
/// P_s/√(2s+1) − P_{s−1}/√(2s−1), and with W_ik = P_k(c_i), B = diag(b),
///
///     A = W X Wᵀ B,     Wᵀ B W = 1                                       (W-transformation, loc. cit. theorem 5.11)
///
/// where X is tridiagonal: X_00 = ½, X_{k,k−1} = −X_{k−1,k} = ξ_k = 1/(2√(4k²−1)), X_{s−1,s−1} = 1/(4s−2). Its
/// eigenvectors follow from a recurrence, X v = μ v; and as changing the sign of every second row and column transposes
/// it (D X D = Xᵀ), D v are the left ones. So no matrix is inverted, and nothing is lost to conditioning:
///
///     A = T diag(μ) T⁻¹,   T = W V,   T⁻¹ = (Vᵀ D V)⁻¹ Vᵀ D Wᵀ B.                                               (1)
///
/// One eigenvalue is real, the others come in pairs, of which one each is kept, a "lane": z_i = Σ_l Re(T_il w_l) with T
/// doubled for the pairs. Columns are scaled so that the last node's T is 1: z_s = Σ_l Re(w_l).
#pragma once

#include <array>
#include <cstddef>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {
namespace radau_detail {

using Real = long double;
struct Complex {
  Real re = 0, im = 0;
  friend constexpr Complex operator+(Complex a, Complex b) { return {a.re + b.re, a.im + b.im}; }
  friend constexpr Complex operator-(Complex a, Complex b) { return {a.re - b.re, a.im - b.im}; }
  friend constexpr Complex operator*(Complex a, Complex b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
  }
  friend constexpr Complex operator*(Real a, Complex b) { return {a * b.re, a * b.im}; }
  friend constexpr Complex operator/(Complex a, Complex b) {
    const Real n = b.re * b.re + b.im * b.im;
    return {(a.re * b.re + a.im * b.im) / n, (a.im * b.re - a.re * b.im) / n};
  }
};

/// Newton's iteration from above: it falls until rounding stops it.
constexpr Real root(Real x) {
  Real y = x > 1 ? x : 1;
  for (Real next = (y + x / y) / 2; next < y; next = (y + x / y) / 2) y = next;
  return y;
}

/// The nodes c; and the eigenvalues of A, the real one, then those above the axis.
template <int s>
struct Given;
template <>
struct Given<3> {
  static constexpr std::array<Real, 3> c{0.155051025721682190199L, 0.644948974278317809839L, 1};
  static constexpr std::array<Complex, 2> mu{
      {{0.274888829595677367738L, 0}, {0.162555585202161316128L, 0.184949324407140784263L}}};
};
template <>
struct Given<5> {
  static constexpr std::array<Real, 5> c{0.0571041961145176821927L, 0.276843013638123827664L, 0.583590432368916820047L,
                                         0.860240135656219447871L, 1};
  static constexpr std::array<Complex, 3> mu{{{0.159065844427469120517L, 0},
                                              {0.133179077018299598975L, 0.0749945118358185229285L},
                                              {0.0650657785457436185945L, 0.116468527740317075734L}}};
};
template <>
struct Given<7> {
  static constexpr std::array<Real, 7> c{0.0293164271597848919659L,
                                         0.148078599668484291836L,
                                         0.336984690281154299096L,
                                         0.558671518771550132084L,
                                         0.769233862030054500942L,
                                         0.926945671319741114835L,
                                         1};
  static constexpr std::array<Complex, 4> mu{{{0.111896465300035076207L, 0},
                                              {0.102285566496898739696L, 0.0394274964380635351398L},
                                              {0.075280411819775110911L, 0.0698196007808333052468L},
                                              {0.0357165582640778415469L, 0.0829531543133316078128L}}};
};

}  // namespace radau_detail

/// The Radau IIA method of s = 3, 5 or 7 stages and order 2s − 1.
template <int s>
struct RadauTableau {
  using Real = radau_detail::Real;
  using Complex = radau_detail::Complex;
  static constexpr int lanes = (s + 1) / 2;

  std::array<Real, s> c = radau_detail::Given<s>::c;           ///< nodes, the last one 1
  std::array<Real, s> b{};                                     ///< weights
  std::array<Complex, lanes> mu = radau_detail::Given<s>::mu;  ///< eigenvalues of A
  std::array<std::array<Complex, lanes>, s> T{};               ///< z_i = Σ_l Re(T_il w_l)
  std::array<std::array<Complex, s>, lanes> T_inverse{};       ///< w_l = Σ_j (T⁻¹)_lj z_j
  /// Of the polynomial u of degree s through u(0) = 0 and u(c_i) = z_i: u(1 + x) − u(1) = Σ_m a_m x^{m+1},
  /// a_m = Σ_l Re(taylor_ml w_l)
  std::array<std::array<Complex, lanes>, s> taylor{};

  constexpr RadauTableau() {
    std::array<std::array<Real, s + 1>, s> W{};
    for (std::size_t i = 0; i < s; ++i) {
      W[i] = legendre(c[i]);
      Real sum = 0;
      for (std::size_t k = 0; k < s; ++k) sum += W[i][k] * W[i][k];
      b[i] = 1 / sum;
    }
    for (std::size_t l = 0; l < lanes; ++l) {
      const auto v = eigenvector(mu[l]);
      Complex norm{}, last{};  // vᵀ D v, and (W v)_s
      for (std::size_t k = 0; k < s; ++k) {
        norm = norm + (k % 2 == 0 ? 1 : -1) * (v[k] * v[k]);
        last = last + W[s - 1][k] * v[k];
      }
      const Real pair = l == 0 ? 1 : 2;
      for (std::size_t i = 0; i < s; ++i) {
        Complex right{}, left{};
        for (std::size_t k = 0; k < s; ++k) {
          right = right + W[i][k] * v[k];
          left = left + ((k % 2 == 0 ? 1 : -1) * W[i][k] * b[i]) * v[k];
        }
        T[i][l] = right / last;  // times `pair`, which T⁻¹ has to undo
        T_inverse[l][i] = pair * (left * last / norm);
      }
    }
    expand(W);
  }

 private:
  static constexpr Real xi(int k) { return 1 / (2 * radau_detail::root(Real(4 * k * k - 1))); }
  /// P_0 … P_s at x
  static constexpr std::array<Real, s + 1> legendre(Real x) {
    std::array<Real, s + 1> p{};
    const Real y = 2 * x - 1;
    Real before = 0, now = 1;
    for (int k = 0; k <= s; ++k) {
      p[std::size_t(k)] = now * radau_detail::root(Real(2 * k + 1));
      const Real next = ((2 * k + 1) * y * now - k * before) / (k + 1);
      before = now;
      now = next;
    }
    return p;
  }
  static constexpr std::array<Complex, s> eigenvector(Complex z) {
    std::array<Complex, s> v{};
    v[0] = {1, 0};
    for (int k = 0; k + 1 < s; ++k) {
      const auto i = std::size_t(k);
      const Complex top = k == 0 ? (Complex{0.5L, 0} - z) * v[0] : xi(k) * v[i - 1] - z * v[i];
      v[i + 1] = (1 / xi(k + 1)) * top;
    }
    return v;
  }
  /// u' = Σ_k g_k P_k with g = Wᵀ B h F, and h F = A⁻¹ z has the lanes w/μ. About x = 1, with y = x − 1,
  /// P_k(1 + y) = √(2k+1) Σ_m binom(k, m) binom(k+m, m) yᵐ.
  constexpr void expand(const std::array<std::array<Real, s + 1>, s>& W) {
    for (std::size_t l = 0; l < lanes; ++l) {
      const Complex inverse = Complex{1, 0} / mu[l];
      for (std::size_t k = 0; k < s; ++k) {
        Complex g{};
        for (std::size_t i = 0; i < s; ++i) g = g + (W[i][k] * b[i]) * T[i][l];
        g = inverse * g;
        Real term = radau_detail::root(Real(2 * int(k) + 1));
        for (std::size_t m = 0; m <= k; ++m) {
          taylor[m][l] = taylor[m][l] + (term / Real(int(m) + 1)) * g;
          term *= Real(int(k) - int(m)) * Real(int(k) + int(m) + 1) / Real((int(m) + 1) * (int(m) + 1));
        }
      }
    }
  }
};

template <int s>
inline constexpr RadauTableau<s> radau_tableau{};

// The Radau IIA tableau (radau_tableau.hpp) in the working precision, laid out for lanes.

/// The tableau in the working precision, a row of lanes or of stages at a time.
template <class Scalar, int s>
struct RadauConstants {
  static constexpr int lanes = 4, used = (s + 1) / 2;
  static constexpr int rows = s <= 4 ? 4 : 8;
  using Lanes = std::array<Scalar, lanes>;
  using Stages = std::array<Scalar, rows>;
  struct ByLane {
    Lanes re{}, im{};
  };
  struct ByStage {
    Stages re{}, im{};  ///< of what Re(w) and Im(w) are multiplied by
  };
  ByLane mu, lambda;                       ///< eigenvalues of A, and their reciprocals
  std::array<ByLane, s> into_lanes;        ///< T⁻¹
  std::array<ByStage, lanes> into_stages;  ///< T
  std::array<ByStage, lanes> into_powers;  ///< a_m of u(1 + x) − u(1) = Σ a_m x^{m+1}
  ByLane start;                            ///< h u'(0)
  std::array<Stages, s> slopes{};          ///< A⁻¹, column by column: h u'(c_i) = Σ_j (A⁻¹)_ij z_j
  std::array<Scalar, s> c{};

  constexpr RadauConstants() {
    const auto& table = radau_tableau<s>;
    for (std::size_t l = 0; l < lanes; ++l) {
      const auto eigenvalue = table.mu[l < used ? l : 0];  // a lane without work still has a matrix
      put(mu, l, eigenvalue);
      put(lambda, l, radau_detail::Complex{1, 0} / eigenvalue);
      if (l >= used) continue;
      radau_detail::Complex slope{};
      for (std::size_t j = 0; j < s; ++j) {
        put(into_lanes[j], l, table.T_inverse[l][j]);
        into_stages[l].re[j] = static_cast<Scalar>(table.T[j][l].re);
        into_stages[l].im[j] = static_cast<Scalar>(-table.T[j][l].im);
        into_powers[l].re[j] = static_cast<Scalar>(table.taylor[j][l].re);
        into_powers[l].im[j] = static_cast<Scalar>(-table.taylor[j][l].im);
        slope = slope + (j % 2 == 0 ? 1 : -1) * static_cast<radau_detail::Real>(j + 1) * table.taylor[j][l];
      }
      start.re[l] = static_cast<Scalar>(slope.re);
      start.im[l] = static_cast<Scalar>(-slope.im);
    }
    for (std::size_t j = 0; j < s; ++j) {
      c[j] = static_cast<Scalar>(table.c[j]);
      for (std::size_t i = 0; i < s; ++i) slopes[j][i] = static_cast<Scalar>(slope(table.c, i, j));
    }
  }

 private:
  /// l_j'(c_i) of Lagrange's polynomials through 0, c_1 … c_s: what A⁻¹ is, right in each entry.
  static constexpr radau_detail::Real slope(const auto& c, std::size_t i, std::size_t j) {
    if (i == j) {
      radau_detail::Real sum = 1 / c[j];
      for (std::size_t m = 0; m < s; ++m)
        if (m != j) sum += 1 / (c[j] - c[m]);
      return sum;
    }
    radau_detail::Real product = c[i] / (c[j] * (c[j] - c[i]));
    for (std::size_t m = 0; m < s; ++m)
      if (m != i && m != j) product *= (c[i] - c[m]) / (c[j] - c[m]);
    return product;
  }
  static constexpr void put(ByLane& to, std::size_t l, radau_detail::Complex z) {
    to.re[l] = static_cast<Scalar>(z.re);
    to.im[l] = static_cast<Scalar>(z.im);
  }
};
template <class Scalar, int s>
inline constexpr RadauConstants<Scalar, s> radau_constants{};

}}  // namespace phistep::PHISTEP_ABI
