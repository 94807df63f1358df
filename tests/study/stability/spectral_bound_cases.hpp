#pragma once

// What spectral_bound.test.cpp and its full half share.

#include <phistep/study/stability/spectral_bound.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>
#include <vector>

#include "instances/preflight.hpp"
#include "support/catch.hpp"

namespace spectral_bound_cases {

using namespace phistep;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Stiffness of unit springs between neighbours of a periodic triangular lattice of side × side particles.
inline SparseRows triangular_lattice(int side) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      for (int k = 0; k < 3; ++k) {
        const double angle = k * std::acos(-1.0) / 3;
        const int dx[] = {1, 0, -1}, dy[] = {0, 1, 1};
        const int i = y * side + x, j = (y + dy[k]) % side * side + (x + dx[k] + side) % side;
        const double n[] = {std::cos(angle), std::sin(angle)};
        for (int a = 0; a < 2; ++a)
          for (int b = 0; b < 2; ++b) {
            entries.emplace_back(2 * i + a, 2 * i + b, n[a] * n[b]);
            entries.emplace_back(2 * j + a, 2 * j + b, n[a] * n[b]);
            entries.emplace_back(2 * i + a, 2 * j + b, -n[a] * n[b]);
            entries.emplace_back(2 * j + a, 2 * i + b, -n[a] * n[b]);
          }
      }
  SparseRows A(2 * side * side, 2 * side * side);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

}  // namespace spectral_bound_cases
