#pragma once

// A solver of y' = f(t, y) that shares nothing with the library's schemes: the linearly implicit Euler rule over H, in n_j
// = 1 … 8 equal steps with one Jacobian, extrapolated to order 8 (Hairer & Wanner, Solving ODEs II, sect. IV.9):
//
//     (I − hJ) Δ = h f(t + h, y),   y ← y + Δ,   T_{j,k+1} = T_{j,k} + (T_{j,k} − T_{j−1,k})/(n_j/n_{j−k} − 1).
//
// Stiff problems and smooth ones, in extended precision: its error at rtol = 1e-10 is far below what is judged by it.

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace problems {

using Vector = Eigen::VectorXd;

/// y(t1) from y(t0). The scale of component i is |y_i| + a.
template <class F>
[[nodiscard]] Vector extrapolate(const F& f, Vector y, double t0, double t1, double a, double rtol = 1e-10) {
  constexpr int columns = 8;
  const auto n = y.size();
  Eigen::MatrixXd J(n, n);
  std::vector<Vector> T(columns);
  double t = t0, H = 1e-4 * (t1 - t0);
  for (int attempts = 0; t < t1; ++attempts) {
    if (attempts > 100000) throw std::runtime_error("extrapolate: too many steps");
    const bool last = t + 1.0001 * H >= t1;
    if (last) H = t1 - t;
    const Vector rate = f(t, y);
    for (Eigen::Index k = 0; k < n; ++k) {
      Vector moved = y;
      const double by = 1e-7 * (std::abs(y[k]) + a);
      moved[k] += by;
      J.col(k) = (f(t, moved) - rate) / by;
    }
    double error = 0;
    for (int j = 1; j <= columns; ++j) {
      const double h = H / j;
      const Eigen::PartialPivLU<Eigen::MatrixXd> lu(Eigen::MatrixXd::Identity(n, n) - h * J);
      Vector z = y;
      for (int m = 1; m <= j; ++m) z += lu.solve(h * f(t + m * h, z));
      // T[k] of the previous row moves to column k + 1 of this one.
      for (int k = 1; k < j; ++k) {
        const double ratio = static_cast<double>(j) / (j - k);
        std::swap(z, T[static_cast<std::size_t>(k - 1)]);
        const Vector& now = T[static_cast<std::size_t>(k - 1)];
        z = (now + (now - z) / (ratio - 1)).eval();
      }
      if (j == columns)
        error = ((z - T[columns - 2]).array() / (rtol * (y.array().abs().max(z.array().abs()) + a))).abs().maxCoeff();
      T[static_cast<std::size_t>(j - 1)] = z;
    }
    const bool good = error <= 1;
    if (good) {
      y = T[columns - 1];
      t = last ? t1 : t + H;
    }
    H *= std::isfinite(error) ? std::clamp(0.8 * std::pow(error, -1.0 / columns), 0.1, 4.0) : 0.1;
  }
  return y;
}

}  // namespace problems
