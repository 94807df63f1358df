/// @file
/// The solution inside an explicit Runge-Kutta step, from its slopes k_j and no force call: with z = 1 − x,
///
///     y(t + xΔt) = y + xΔt {p₀ + z [p₁ + x (p₂ + z (p₃ + x (p₄ + …)))]},     p_m = Σ_j P_mj k_j                   (1)
///     p₀ = (y⁺ − y)/Δt,   p₁ = k_0 − p₀,   p₂ = 2p₀ − k_0 − k⁺                                                  (2)
///
/// (Hairer, Nørsett & Wanner, Solving ODEs I, sect. II.6, eq. 6.29). (2) alone is Hermite's cubic; the tableau has the rest.
#pragma once

#include <array>
#include <cstddef>
#include <iterator>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Tableau>
class RungeKuttaInterpolant {
  static constexpr std::size_t stages = Tableau::stages, rows = 3 + std::size(Tableau::inside);

  [[nodiscard]] static constexpr long double P(std::size_t m, std::size_t j) {
    const long double b = Tableau::a[Tableau::end][j], first = j == 0 ? 1 : 0, last = j == Tableau::end ? 1 : 0;
    if (m == 0) return b;
    if (m == 1) return first - b;
    if (m == 2) return 2 * b - first - last;
    return Tableau::inside[m - 3][j];
  }

 public:
  using Weights = std::array<long double, stages>;

  /// The weights w_j(x) in y(t + xΔt) = y + Δt Σ_j w_j k_j.
  [[nodiscard]] static constexpr Weights weights(long double x) {
    Weights w{};
    for (std::size_t j = 0; j < stages; ++j) {
      for (std::size_t m = rows; m-- > 0;) w[j] = P(m, j) + (m % 2 == 0 ? 1 - x : x) * w[j];
      w[j] *= x;
    }
    return w;
  }
  /// out = (1) at x, of the step dt from y0 with slopes k. The r of a motion moves with v = y0.v + Δt Σ a_jl k_l at stage j.
  template <State S, class Rate>
  static void at(ScalarOf<S> x, ScalarOf<S> dt, const PlainState<S>& y0, const std::array<Rate, stages>& k,
                 PlainState<S>& out) {
    using Scalar = ScalarOf<S>;
    const Weights w = weights(static_cast<long double>(x));
    for_each_block([](auto, auto& to, const auto& from) { to = from; }, Blocks<S>::all(out), Blocks<S>::all(y0));
    add<S>(out, w, dt, k);
    if constexpr (Blocks<S>::drifts) {
      auto& r = position_of<S>(out);
      r += x * dt * velocity_of<S>(y0);
      for (std::size_t l = 0; l < stages; ++l) {
        long double sum = 0;
        for (std::size_t j = l + 1; j < stages; ++j) sum += w[j] * Tableau::a[j][l];
        if (sum != 0) r += dt * (dt * (static_cast<Scalar>(sum) * std::get<0>(Rate::blocks(k[l]))));
      }
    }
  }

 private:
  template <State S, class Rate>
  static void add(PlainState<S>& out, const Weights& w, ScalarOf<S> dt, const std::array<Rate, stages>& k) {
    for (std::size_t j = 0; j < stages; ++j)
      if (w[j] != 0)
        for_each_block(
            [by = dt * static_cast<ScalarOf<S>>(w[j])](auto, auto& to, const auto& slope) { to += by * slope; },
            Blocks<S>::solved(out), Rate::blocks(k[j]));
  }
};

}}  // namespace phistep::PHISTEP_ABI
