#pragma once

// What the quick and the full half of step/affine share.
#include <phistep/sparse.hpp>

#include <Eigen/SparseCholesky>

#include <cmath>

#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using Y = Motion<Vec>;

namespace affine_cases {

/// Heat on a rod, cold ends: tridiagonal, symmetric.
inline Eigen::SparseMatrix<double> rod(Eigen::Index n) {
  std::vector<Eigen::Triplet<double>> entries;
  const double scale = static_cast<double>((n + 1) * (n + 1));
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, -2 * scale);
    if (i > 0) entries.emplace_back(i, i - 1, scale);
    if (i + 1 < n) entries.emplace_back(i, i + 1, scale);
  }
  Eigen::SparseMatrix<double> A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

/// 2^k − 1 steps look at their residual k times: one force call each.
inline constexpr int steps = 31, looks = 5;

inline Statistics run(auto y, const auto& force, auto scheme, const auto&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  const RunReport report = integrate(stepper, y, {0, steps * 0.01}, fixed(0.01));
  CAPTURE(report.message());
  REQUIRE(report);
  REQUIRE(report.statistics.steps == steps);
  return report.statistics;
}

struct Driven {
  static constexpr bool is_affine = true;
  Vec operator()(const Vec& y, double t) const { return std::sin(t) - 3 * y.array(); }
  Mat jacobian(const Vec& y, double) const { return -3 * Mat::Identity(y.size(), y.size()); }
};
struct WrongSign {
  static constexpr bool is_affine = true;
  Vec operator()(const Vec& r) const { return -r; }
  Mat jacobian(const Vec&) const { return Mat::Identity(3, 3); }
};

}  // namespace affine_cases
