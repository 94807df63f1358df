/// @file
/// The way of a motion through one step, from what is known at its ends: with x = (t − t0)/h and D0 … D2 what Taylor's
/// polynomial from t0 leaves of r1, h v1 and h² a1,
///
///     r(x)   = r0 + h v0 x + ½h² a0 x² + x³ (c3 + c4 x + c5 x²),                                                 (1)
///     c3 = 10 D0 − 4 D1 + ½D2,   c4 = −15 D0 + 7 D1 − D2,   c5 = 6 D0 − 3 D1 + ½D2
///
/// the polynomial of degree 5 through r, v and a at both ends, off by O(h⁶). Integrals over the step by the rule of Gauss
/// and Lobatto with four nodes, exact to degree 5:
///
///     ∫f dt ≈ h (f(0) + 5 f(½−√5/10) + 5 f(½+√5/10) + f(1))/12                                                  (2)
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The inner nodes of (2), and the weights of an end and of an inner node.
inline constexpr std::array<double, 2> lobatto_nodes{0.27639320225002103036, 0.72360679774997896964};
inline constexpr double lobatto_end = 1.0 / 12, lobatto_inner = 5.0 / 12;

/// out = (r, v) at x, 0 ≤ x ≤ 1, by (1). @param a0, a1  the accelerations at the ends, shaped like v
template <State S, class Block>
void place_between(ScalarOf<S> x, ScalarOf<S> h, const PlainState<S>& y0, const Block& a0, const PlainState<S>& y1,
                   const Block& a1, PlainState<S>& out) {
  using Scalar = ScalarOf<S>;
  const auto &r0 = position_of<S>(y0), &v0 = velocity_of<S>(y0), &r1 = position_of<S>(y1), &v1 = velocity_of<S>(y1);
  auto &r = position_of<S>(out), &v = velocity_of<S>(out);
  const Scalar half{0.5}, square = h * h;
  for (Index i = 0; i < r0.size(); ++i) {
    const Scalar hv = h * v0.data()[i], ha = square * a0.data()[i];
    const Scalar d0 = r1.data()[i] - r0.data()[i] - hv - half * ha, d1 = h * v1.data()[i] - hv - ha,
                 d2 = square * a1.data()[i] - ha;
    const Scalar c3 = 10 * d0 - 4 * d1 + half * d2, c4 = -15 * d0 + 7 * d1 - d2, c5 = 6 * d0 - 3 * d1 + half * d2;
    r.data()[i] = r0.data()[i] + x * (hv + x * (half * ha + x * (c3 + x * (c4 + x * c5))));
    v.data()[i] = (hv + x * (ha + x * (3 * c3 + x * (4 * c4 + x * (5 * c5))))) / h;
  }
}

/// ∫ f(x, y) dt over the step, for each f of an array, by (2) on (1). Where the rule is off `mean` by more than half of ∫ |f| dt,
/// the step doesn't resolve it, and that counts.
/// @param place  scratch
template <State S, class Block, class Number, std::size_t n>
[[nodiscard]] std::array<Number, n> integrate_on_path(ScalarOf<S> h, const PlainState<S>& y0, const Block& a0,
                                                      const PlainState<S>& y1, const Block& a1, PlainState<S>& place,
                                                      const std::array<Number, n>& mean, auto&& f) {
  std::array<Number, n> integral{}, size{};
  const auto add = [&](double weight, const std::array<Number, n>& values) {
    const Number share = static_cast<Number>(h) * static_cast<Number>(weight);
    for (std::size_t k = 0; k < n; ++k) integral[k] += share * values[k], size[k] += std::abs(share * values[k]);
  };
  add(lobatto_end, f(0, y0));
  add(lobatto_end, f(1, y1));
  for (const double x : lobatto_nodes) {
    place_between<S>(static_cast<ScalarOf<S>>(x), h, y0, a0, y1, a1, place);
    add(lobatto_inner, f(x, place));
  }
  for (std::size_t k = 0; k < n; ++k)
    if (!(std::abs(integral[k] - mean[k]) <= size[k] / 2)) integral[k] = mean[k];
  return integral;
}

}}  // namespace phistep::PHISTEP_ABI
