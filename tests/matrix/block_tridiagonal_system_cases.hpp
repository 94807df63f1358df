#pragma once

// What block_tridiagonal_system.test.cpp and its full half share.

#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>

#include "support/catch.hpp"

namespace block_tridiagonal_cases {

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;

inline Vec wave(Eigen::Index n) { return Vec::LinSpaced(n, 0, 7).array().sin(); }

/// The Brusselator on a line, (u, w) point by point: u_t = 1 + u²w − 4u + D Δu, w_t = 3u − u²w + D Δw.
inline Vec brusselator(const Vec& y) {
  Vec rate(y.size());
  const Eigen::Index points = y.size() / 2;
  for (Eigen::Index i = 0; i < points; ++i) {
    const double u = y[2 * i], w = y[2 * i + 1];
    const auto laplacian = [&](Eigen::Index c, double boundary) {
      const double left = i > 0 ? y[2 * i - 2 + c] : boundary, right = i + 1 < points ? y[2 * i + 2 + c] : boundary;
      return 20 * (left - 2 * y[2 * i + c] + right);
    };
    rate[2 * i] = 1 + u * u * w - 4 * u + laplacian(0, 1);
    rate[2 * i + 1] = 3 * u - u * u * w + laplacian(1, 3);
  }
  return rate;
}
inline Vec start(Eigen::Index points) {
  Vec y(2 * points);
  for (Eigen::Index i = 0; i < points; ++i)
    y[2 * i] = 1 + 0.5 * std::sin(0.1 * static_cast<double>(i)), y[2 * i + 1] = 3;
  return y;
}
/// A component that sees 4 to either side, each with a weight of its own: three components a block.
inline Vec wide(const Vec& y) {
  const Eigen::Index n = y.size();
  Vec rate(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    rate[i] = -9 * y[i] - y[i] * y[i] * y[i];
    for (Eigen::Index j = std::max<Eigen::Index>(0, (i / 3 - 1) * 3); j < std::min(n, (i / 3 + 2) * 3); ++j)
      rate[i] += std::cos(static_cast<double>(3 * i + 5 * j)) * y[j];
  }
  return rate;
}

template <class State>
Statistics steps(State& y, auto force, auto scheme, int count, double dt, const auto&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < count; ++k) {
    const StepReport report = stepper.step(y, dt * k, dt);
    if (!report) throw std::runtime_error(report.message());
  }
  return stepper.statistics();
}

}  // namespace block_tridiagonal_cases
