// The reaction and diffusion of Gray and Scott (J. E. Pearson, Science 261 (1993) 189) on a periodic square, at one point:
//
//     u' = D_u ∇²u − uv² + F (1 − u),     v' = D_v ∇²v + uv² − (F + k) v
#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace gray_scott {

constexpr double length = 2.5, D_u = 8e-5, D_v = 4e-5, F = 0.024, k = 0.06;

/// u and v, or their rates.
using Pair = std::array<double, 2>;

/// u = 1, v = 0, but for a square with waves in the middle.
[[nodiscard]] inline Pair start(double x, double z) {
  if (std::abs(x - length / 2) > 0.25 || std::abs(z - length / 2) > 0.25) return {1, 0};
  const double wave = std::sin(4 * std::numbers::pi * x) * std::sin(4 * std::numbers::pi * z), v = 0.25 * wave * wave;
  return {1 - 2 * v, v};
}
/// u' and v' but for diffusion.
[[nodiscard]] inline Pair reaction(double u, double v) { return {-u * v * v + F * (1 - u), u * v * v - (F + k) * v}; }
/// Its Jacobian, row by row.
[[nodiscard]] inline std::array<Pair, 2> tangent(double u, double v) {
  return {{{-v * v - F, -2 * u * v}, {v * v, 2 * u * v - F - k}}};
}

}  // namespace gray_scott
