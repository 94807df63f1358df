/// @file
/// A motion inside a Runge-Kutta-Nyström step: the polynomial through the accelerations k_j that the step knows at
/// c_j ∈ [0, 1], L_j being Lagrange's polynomials, integrated twice, and bent to meet the end,
///
///     r(x) = r + xΔt v + Δt² Σ B_j(x) k_j + (3x²−2x³) δ_r + (x³−x²) Δt δ_v,    B_j" = L_j, B_j(0) = B_j'(0) = 0   (1)
///
/// with δ_r, δ_v what is missing from r⁺, v⁺ at x = 1; v(x) is its derivative. No force is called. What the k_j of the inner
/// stages lack shows in it: the tests tell which orders are left.
#pragma once

#include <array>
#include <cstddef>
#include <iterator>
#include <tuple>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Of the pair `Tableau`, whose `dense` names the stages to go through.
template <class Tableau>
class NystromInterpolant {
  static constexpr std::size_t nodes = std::size(Tableau::dense);
  using Weights = std::array<long double, nodes>;
  static constexpr long double node(std::size_t n) { return Tableau::c[Tableau::dense[n]]; }

  /// Of each L_j, the coefficients of 1, x, x², …
  static constexpr auto lagrange = [] {
    std::array<Weights, nodes> all{};
    for (std::size_t j = 0; j < nodes; ++j) {
      all[j][0] = 1;
      std::size_t degree = 0;
      for (std::size_t k = 0; k < nodes; ++k) {
        if (k == j) continue;
        const long double by = 1 / (node(j) - node(k));
        ++degree;
        for (std::size_t m = degree + 1; m-- > 0;)
          all[j][m] = by * ((m > 0 ? all[j][m - 1] : 0) - (m < degree ? node(k) * all[j][m] : 0));
      }
    }
    return all;
  }();

  struct Integrals {
    Weights twice{}, once{};  ///< B_j, B_j'
    /// In long double: the coefficients alternate, and are large.
    constexpr explicit Integrals(long double x) {
      for (std::size_t j = 0; j < nodes; ++j) {
        for (std::size_t m = nodes; m-- > 0;) {
          const auto power = static_cast<long double>(m);
          twice[j] = twice[j] * x + lagrange[j][m] / ((power + 1) * (power + 2));
          once[j] = once[j] * x + lagrange[j][m] / (power + 1);
        }
        twice[j] *= x * x;
        once[j] *= x;
      }
    }
  };
  static constexpr Integrals at_end{1};

 public:
  /// out = (1) and its derivative at x, of the step dt from y0 to y1 with accelerations k.
  template <State S, class Rate, std::size_t stages>
  static void at(ScalarOf<S> x, ScalarOf<S> dt, const PlainState<S>& y0, const PlainState<S>& y1,
                 const std::array<Rate, stages>& k, PlainState<S>& out) {
    using Scalar = ScalarOf<S>;
    const auto z = static_cast<long double>(x);
    const Integrals here{z};
    const long double rise = z * z * (3 - 2 * z), tilt = z * z * (z - 1), rise_rate = 6 * z * (1 - z),
                      tilt_rate = z * (3 * z - 2);
    const auto scalar = [](long double weight) { return static_cast<Scalar>(weight); };
    const auto &r0 = position_of<S>(y0), &v0 = velocity_of<S>(y0), &r1 = position_of<S>(y1), &v1 = velocity_of<S>(y1);
    auto &r = position_of<S>(out), &v = velocity_of<S>(out);
    // With s, t the rise and tilt: s r⁺ + (1 − s) r = r + s (r⁺ − r), and so on.
    r = r0 + scalar(rise) * (r1 - r0) + dt * (scalar(z - rise) * v0 + scalar(tilt) * (v1 - v0));
    v = v0 + scalar(tilt_rate) * (v1 - v0) + scalar(rise_rate) * ((r1 - r0) / dt - v0);
    for (std::size_t j = 0; j < nodes; ++j) {
      const auto& a = std::get<0>(Rate::blocks(k[static_cast<std::size_t>(Tableau::dense[j])]));
      r += dt * (dt * (scalar(here.twice[j] - rise * at_end.twice[j] - tilt * at_end.once[j]) * a));
      v += dt * (scalar(here.once[j] - rise_rate * at_end.twice[j] - tilt_rate * at_end.once[j]) * a);
    }
  }
};

}}  // namespace phistep::PHISTEP_ABI
