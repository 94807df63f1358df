/// @file
/// The Radau IIA tableau (radau_tableau.hpp) in the working precision, laid out for lanes.
#pragma once

#include <array>
#include <cstddef>

#include "phistep/base/version.hpp"
#include "phistep/schemes/radau/radau_tableau.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The tableau in the working precision, a row of lanes or of stages at a time.
template <class Scalar, int s>
struct RadauConstants {
  static constexpr int lanes = 4, used = (s + 1) / 2, most = 7;
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
  std::array<ByLane, most> powers;         ///< T⁻¹ of z_j = c_j^{m+1}
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
      for (std::size_t m = 0; m < most; ++m) {
        radau_detail::Complex w{};
        for (std::size_t j = 0; j < s; ++j) {
          radau_detail::Real c_j = 1;
          for (std::size_t k = 0; k <= m; ++k) c_j *= table.c[j];
          w = w + c_j * table.T_inverse[l][j];
        }
        put(powers[m], l, w);
      }
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
