// The plate of the heat example: ρc θ' = ∇·(k ∇θ) in finite volumes, M θ' = A θ.
#pragma once

#include <Eigen/SparseCore>

#include <cmath>
#include <utility>
#include <vector>

using Vec = Eigen::VectorXd;
using Matrix = Eigen::SparseMatrix<double>;

/// The right-hand side, with its Jacobian: all that the stepper asks for.
struct Conduction {
  Matrix A;  // [W/(m³ K)]
  Vec operator()(const Vec& theta) const { return A * theta; }
  const Matrix& jacobian(const Vec& /*theta*/) const { return A; }
};

struct Plate {
  int n;         // cells along a side
  double dx;     // [m]
  Vec k, rho_c;  // conductivity [W/(m K)] and capacity [J/(m³ K)] of the cells
  Vec start;     // [K]

  explicit Plate(int cells) : n{cells}, dx{0.1 / cells}, k(n * n), rho_c(n * n), start(n * n) {
    for (int i = 0; i < n * n; ++i) {
      const double x = (i % n + 0.5) / n, y = (i / n + 0.5) / n;
      const bool steel = x > 0.55 && x < 0.65, hot = std::abs(x - 0.4) < 0.2 && std::abs(y - 0.5) < 0.2;
      k[i] = steel ? 50 : 400, rho_c[i] = steel ? 3.6e6 : 3.45e6, start[i] = hot ? 100 : 0;
    }
  }
  /// A face conducts with the harmonic mean of its two cells; an edge is half a cell away.
  [[nodiscard]] Conduction conduction() const {
    std::vector<Eigen::Triplet<double>> entries;
    const auto couple = [&](int i, int j) {
      const double g = 2 / (1 / k[i] + 1 / k[j]) / (dx * dx);
      for (const auto& [a, b] : {std::pair{i, j}, std::pair{j, i}})
        entries.insert(entries.end(), {{a, b, g}, {a, a, -g}});
    };
    for (int i = 0; i < n * n; ++i) {
      if (i % n + 1 < n) couple(i, i + 1);
      if (i + n < n * n) couple(i, i + n);
      const int edges = (i % n == 0) + (i % n == n - 1) + (i < n) + (i >= n * n - n);
      entries.emplace_back(i, i, -edges * 2 * k[i] / (dx * dx));
    }
    Conduction made{Matrix(n * n, n * n)};
    made.A.setFromTriplets(entries.begin(), entries.end());
    return made;
  }
};
