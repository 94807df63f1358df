#pragma once

// Heat on a rod, for the full and the long half of run/stepper/affine.
#include <phistep/sparse.hpp>

#include <vector>

#include "run/stepper/affine_cases.hpp"

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

}  // namespace affine_cases
