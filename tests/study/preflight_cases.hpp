#pragma once

// What preflight.test.cpp and its full half share: scenes that are run at preflight's Δt and beyond.

#include <phistep/preflight.hpp>
#include <phistep/sparse.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "problems/heat.hpp"
#include "study/assess_cases.hpp"
#include "support/catch.hpp"

namespace preflight_cases {

using namespace phistep;
using assess_cases::chain;
using assess_cases::chain_state;
using Vec = Eigen::VectorXd;
using Mat2 = Eigen::Matrix2Xd;
using Mat3 = Eigen::Matrix3Xd;

/// The largest factor by which a tiny random change of the state has grown in up to `steps` steps; infinite where a step
/// fails. Positions and first-order states are changed, velocities are not: a free network then doesn't drift away.
template <class S>
double growth(auto& stepper, const S& start, double dt, int steps) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  S y = start;
  auto& moved = std::get<0>(Blocks<S>::all(y));
  const auto& still = std::get<0>(Blocks<S>::all(start));
  for (Eigen::Index i = 0; i < moved.size(); ++i) moved.data()[i] += 1e-9 * normal(random);
  const double before = (moved - still).norm();
  double most = 1;
  stepper.reset();
  for (int n = 0; n < steps; ++n) {
    if (!stepper.step(y, dt * n, dt)) return std::numeric_limits<double>::infinity();
    const double now = (moved - still).norm() / before;
    most = std::max(most, std::isfinite(now) ? now : std::numeric_limits<double>::infinity());
    if (most > 1e6) break;
  }
  return most;
}

/// At the limit itself, errors of a scheme that doesn't damp grow in proportion to time; a thousandth below, by at most
/// 1/√(1 − 0.999²) = 22 for each mode. At 1.5 times the limit Verlet's stiffest mode grows by 6.9 a step.
inline constexpr double bounded = 60, blown_up = 1e6;

/// start must be at rest, so that the change is all that moves.
template <class S>
PreflightReport check_scene(const char* name, auto stepper, const S& start) {
  const PreflightReport report = preflight(stepper, start, 1.0);
  INFO(name << ": " << report.text());
  REQUIRE(report.stable_dt > 0);
  REQUIRE(std::isfinite(report.stable_dt));
  const double below = growth(stepper, start, report.stable_dt, 4000);
  CHECK(below < bounded);
  CHECK(growth(stepper, start, 1.5 * report.stable_dt, 4000) >= blown_up);
  // Where it really ends.
  double low = 1, high = 1.5;
  while (high - low > 0.01) {
    const double middle = (low + high) / 2;
    (growth(stepper, start, middle * report.stable_dt, 1000) < blown_up ? low : high) = middle;
  }
  std::printf("%-46s %s  stable dt %-10.4g true limit / it: %.2f   growth at it: %.3g\n", name,
              report.whole.exact ? "eigenvalues" : "bounds     ", report.stable_dt, low, below);
  return report;
}

/// Springs between all pairs nearer than `reach`, at rest as they are.
template <class Positions>
std::vector<Spring> net(const Positions& r, double k, double reach) {
  std::vector<Spring> springs;
  for (Eigen::Index i = 0; i < r.cols(); ++i)
    for (Eigen::Index j = i + 1; j < r.cols(); ++j)
      if (const double length = (r.col(i) - r.col(j)).norm(); length < reach) springs.push_back({i, j, k, length});
  return springs;
}
template <class Positions>
Motion<Positions> at_rest(const Positions& r) {
  return {r, Positions(Positions::Zero(r.rows(), r.cols()))};
}
inline Mat2 triangles(int side) {
  Mat2 r(2, side * side);
  for (int i = 0; i < r.cols(); ++i) r.col(i) << i % side + 0.5 * (i / side), std::sqrt(0.75) * (i / side);
  return r;
}

/// −Δ with zero beside the edges, on a side×side grid of spacing 1.
inline Eigen::SparseMatrix<double> laplacian_2d(int side) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < side * side; ++i) {
    entries.emplace_back(i, i, -4);
    if (i % side > 0) entries.emplace_back(i, i - 1, 1);
    if (i % side < side - 1) entries.emplace_back(i, i + 1, 1);
    if (i >= side) entries.emplace_back(i, i - side, 1);
    if (i + side < side * side) entries.emplace_back(i, i + side, 1);
  }
  Eigen::SparseMatrix<double> A(side * side, side * side);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

}  // namespace preflight_cases
