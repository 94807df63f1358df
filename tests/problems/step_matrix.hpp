#pragma once

// What a step is for (r, v, a) or (y, a) of a scheme that carries an acceleration a, from steps that it takes.

#include <Eigen/Core>
#include <Eigen/QR>
#include <phistep/phistep.hpp>

#include <complex>
#include <limits>

#include "problems/dahlquist.hpp"
#include "problems/march.hpp"

namespace problems {

/// Of r'' = −Ω² r, from what four steps from each of two starts do.
template <class T>
[[nodiscard]] Eigen::Matrix<T, 3, 3> step_matrix(auto scheme, T omega) {
  using V = Eigen::Matrix<T, 1, 1>;
  Eigen::Matrix<T, 3, 6> from, to;
  for (int start = 0; start < 2; ++start) {
    phistep::Motion<V> y{V(T(start == 0)), V(start == 0 ? T(0) : omega)};
    phistep::PhiStepper stepper{y, [=](const V& x) -> V { return -omega * omega * x; }, scheme};
    for (int n = 0; n < 4; ++n) {
      step(stepper, y, T(n), T(1));
      const Eigen::Matrix<T, 3, 1> now{y.r[0], y.v[0], stepper.working().a().force[0]};
      if (n > 0) to.col(3 * start + n - 1) = now;
      if (n < 3) from.col(3 * start + n) = now;
    }
  }
  const auto size = from.colwise().norm().cwiseInverse().eval();
  from = from * size.asDiagonal(), to = to * size.asDiagonal();
  return from.transpose().colPivHouseholderQr().solve(to.transpose()).transpose();
}
/// Of y' = zy, from three steps; NaN where one of them is refused.
[[nodiscard]] inline Eigen::Matrix2cd step_matrix(auto scheme, std::complex<double> z) {
  Eigen::Vector2d y{1, 0};
  phistep::PhiStepper stepper{y, ComplexDahlquist{z}, scheme};
  Eigen::Matrix<std::complex<double>, 2, 3> seen;
  seen.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (int n = 0; n < 3 && stepper.step(y, n, 1); ++n) {
    const auto& a = stepper.working().a().rate;
    seen.col(n) << std::complex{y[0], y[1]}, std::complex{a[0], a[1]};
  }
  return seen.rightCols<2>() * seen.leftCols<2>().inverse();
}

}  // namespace problems
