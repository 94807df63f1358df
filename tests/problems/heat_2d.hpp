#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <array>
#include <cmath>

namespace problems {

/// u_t = u_xx + u_yy on the unit square, u = 0 around it, by the five-point stencil on 64 × 64 inner points: from a sum of
/// eigenvectors of the stencil, of which the solution is known to rounding. Needs <phistep/sparse.hpp>.
struct Heat2D : phistep::ForceTerm {
  using State = Eigen::VectorXd;
  static constexpr int side = 64;
  static constexpr double end = 0.05;
  static constexpr double scale = (side + 1.0) * (side + 1.0);  // 1/Δx²

  static constexpr bool uses_time = false, is_affine = true, is_symmetric = true;
  static constexpr phistep::Structure structure = phistep::Structure::sparse;

  /// The sum of sin(pπx) sin(qπy) exp(λt) over the modes, with the stencil's λ.
  [[nodiscard]] static State exact(double t) {
    State u = State::Zero(side * side);
    for (const auto& [p, q] : std::array<std::array<int, 2>, 4>{{{1, 1}, {2, 3}, {7, 5}, {20, 31}}}) {
      const double decay = std::exp(-4 * scale * (square(half_sine(p)) + square(half_sine(q))) * t);
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i)
          u[i + side * j] += decay * std::sin(p * pi * (i + 1) / (side + 1)) * std::sin(q * pi * (j + 1) / (side + 1));
    }
    return u;
  }
  void add(auto /*t*/, const auto& state, auto& out) const {
    const double* const u = state.y.data();
    double* const rate = out.rate.data();
    for (int j = 0; j < side; ++j) {
      const double *const here = u + side * j, *const below = j > 0 ? here - side : nullptr,
                          *const above = j + 1 < side ? here + side : nullptr;
      double* const to = rate + side * j;
      for (int i = 0; i < side; ++i) to[i] -= scale * 4 * here[i];
      for (int i = 1; i < side; ++i) to[i] += scale * here[i - 1];
      for (int i = 0; i + 1 < side; ++i) to[i] += scale * here[i + 1];
      if (below)
        for (int i = 0; i < side; ++i) to[i] += scale * below[i];
      if (above)
        for (int i = 0; i < side; ++i) to[i] += scale * above[i];
    }
  }
  void add_jacobian(auto /*t*/, const auto& /*state*/, auto& sink) const {
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i) {
        const int k = i + side * j;
        sink.rate(k, k, -4 * scale);
        if (i > 0) sink.rate(k, k - 1, scale);
        if (i + 1 < side) sink.rate(k, k + 1, scale);
        if (j > 0) sink.rate(k, k - side, scale);
        if (j + 1 < side) sink.rate(k, k + side, scale);
      }
  }

 private:
  static constexpr double pi = 3.14159265358979323846;
  [[nodiscard]] static double square(double x) { return x * x; }
  [[nodiscard]] static double half_sine(int p) { return std::sin(p * pi / (2 * (side + 1))); }
};

}  // namespace problems
