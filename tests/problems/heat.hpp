#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <cmath>
#include <vector>

namespace problems {

/// u_t = u_xx on (0, 1) with u = 0 at both ends, by central differences at n inner points. Matrix: dense or sparse.
template <class Matrix>
struct Heat {
  using State = Eigen::VectorXd;
  Matrix laplacian;

  explicit Heat(int n) {
    const double scale = (n + 1.0) * (n + 1.0);
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < n; ++i) {
      entries.emplace_back(i, i, -2 * scale);
      if (i > 0) entries.emplace_back(i, i - 1, scale);
      if (i + 1 < n) entries.emplace_back(i, i + 1, scale);
    }
    Eigen::SparseMatrix<double> sparse(n, n);
    sparse.setFromTriplets(entries.begin(), entries.end());
    laplacian = sparse;
  }
  State operator()(const State& u) const { return laplacian * u; }
  [[nodiscard]] const Matrix& jacobian(const State& /*u*/) const { return laplacian; }

  /// sin(jπx) at the inner points: an eigenvector of the differences too.
  [[nodiscard]] static State mode(int n, int j) {
    State u(n);
    for (int i = 0; i < n; ++i) u[i] = std::sin(j * pi * (i + 1) / (n + 1));
    return u;
  }
  /// Its eigenvalue, −4/Δx² sin²(jπΔx/2).
  [[nodiscard]] static double eigenvalue(int n, int j) {
    const double s = std::sin(j * pi / (2.0 * (n + 1)));
    return -4 * (n + 1.0) * (n + 1.0) * s * s;
  }
  static constexpr double pi = 3.14159265358979323846;
};

}  // namespace problems
