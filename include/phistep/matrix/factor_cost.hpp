/// @file
/// What a sparse factorization L D Lᵀ costs, counted from the pattern alone: the fill under the minimum degree ordering (P. R.
/// Amestoy, T. A. Davis & I. S. Duff, SIAM J. Matrix Anal. Appl. 17 (1996) 886) by the elimination tree.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <cstdint>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

struct FactorCost {
  std::int64_t unknowns = 0;
  std::int64_t entries = 0;   ///< of L, below the diagonal: 12 bytes and two products of each solve apiece
  std::int64_t products = 0;  ///< Σ c_j² over the columns' entries c_j: multiplications of a factorization

  [[nodiscard]] double entries_an_unknown() const {
    return unknowns > 0 ? static_cast<double>(entries) / static_cast<double>(unknowns) : 0;
  }
  [[nodiscard]] double products_an_unknown() const {
    return unknowns > 0 ? static_cast<double>(products) / static_cast<double>(unknowns) : 0;
  }
};

/// Of a square matrix with this pattern and its transpose's; LU on the diagonal has twice the entries and products. Values
/// don't count. Takes about a tenth of what the factorization would, as SimplicialLDLT::analyzePattern does.
template <class Scalar>
[[nodiscard]] FactorCost factor_cost(const Eigen::SparseMatrix<Scalar>& pattern) {
  using Matrix = Eigen::SparseMatrix<double>;
  struct Counts : Eigen::SimplicialLDLT<Matrix> {
    [[nodiscard]] const auto& of_columns() const { return this->m_nonZerosPerCol; }
  };
  Matrix both = pattern.template cast<double>();
  for (Eigen::Index k = 0; k < both.nonZeros(); ++k) both.valuePtr()[k] = 1;
  both = Matrix(both.transpose()) + both;
  Counts counts;
  counts.analyzePattern(both);
  FactorCost cost{.unknowns = both.cols()};
  for (Eigen::Index j = 0; j < both.cols(); ++j) {
    const std::int64_t c = counts.of_columns()[j];
    cost.entries += c;
    cost.products += c * c;
  }
  return cost;
}

}  // namespace phistep::inline PHISTEP_ABI
