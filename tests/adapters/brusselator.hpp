// The problem of the tests on ranks.
#pragma once

#include <cmath>

namespace {
/// The Brusselator with diffusion on a periodic N × N grid (Hairer & Wanner, Solving ODEs II, p. 151), u and v interleaved.
constexpr int N = 12;
constexpr double diffusion = 0.1 * N * N;
double u0(int j) { return 22 * (j / double(N)) * std::pow(1 - j / double(N), 1.5); }
double v0(int i) { return 27 * (i / double(N)) * std::pow(1 - i / double(N), 1.5); }
/// @param at  at(rows on, columns on, component)
void reaction(auto&& at, double& fu, double& fv) {
  const double u = at(0, 0, 0), v = at(0, 0, 1);
  fu = 1 + u * u * v - 4.4 * u + diffusion * (at(0, -1, 0) + at(0, 1, 0) + at(-1, 0, 0) + at(1, 0, 0) - 4 * u);
  fv = 3.4 * u - u * u * v + diffusion * (at(0, -1, 1) + at(0, 1, 1) + at(-1, 0, 1) + at(1, 0, 1) - 4 * v);
}
}  // namespace
