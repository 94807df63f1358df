#pragma once

// What the files assess_*.full.cpp and their quick half, tests/preflight.test.cpp, share.

#include <phistep/preflight.hpp>
#include <phistep/sparse.hpp>

#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "instances/preflight.hpp"
#include "support/catch.hpp"

namespace assess_cases {

using namespace phistep;
using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

inline constexpr double infinite = std::numeric_limits<double>::infinity(),
                        nan_value = std::numeric_limits<double>::quiet_NaN();

inline std::vector<Spring> chain(int n, double k) {
  std::vector<Spring> springs;
  for (int i = 0; i + 1 < n; ++i) springs.push_back({i, i + 1, k, 1.0});
  return springs;
}
inline Motion<Vec> chain_state(int n) { return {Vec::LinSpaced(n, 0, n - 1), Vec::Zero(n)}; }
/// −k × (the chain's differences), all of it linear.
inline Sparse chain_matrix(int n, double k) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i + 1 < n; ++i)
    for (const auto& [a, b, x] : {std::tuple{i, i, -k}, {i + 1, i + 1, -k}, {i, i + 1, k}, {i + 1, i, k}})
      entries.emplace_back(a, b, x);
  Sparse K(n, n);
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}
struct ChainForce {
  double k;
  Vec operator()(const Vec& r) const {
    Vec f = Vec::Zero(r.size());
    for (Eigen::Index i = 0; i + 1 < r.size(); ++i) {
      const double pull = k * (r[i + 1] - r[i] - 1);
      f[i] += pull, f[i + 1] -= pull;
    }
    return f;
  }
};
inline bool mentions(const PreflightReport& report, const std::string& what) {
  return report.text().find(what) != std::string::npos;
}

}  // namespace assess_cases
