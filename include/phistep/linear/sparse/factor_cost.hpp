/// @file
/// What a sparse factorization L D Lᵀ costs, counted from the pattern alone: the fill under the minimum degree ordering (P. R.
/// Amestoy, T. A. Davis & I. S. Duff, SIAM J. Matrix Anal. Appl. 17 (1996) 886) by the elimination tree.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

struct FactorCost {
  std::int64_t unknowns = 0;  ///< rows of the matrix; 0: not counted
  std::int64_t entries = 0;   ///< of L, below the diagonal: 12 bytes and two products of each solve apiece
  std::int64_t products = 0;  ///< Σ c_j² over the columns' entries c_j: multiplications of a factorization

  [[nodiscard]] double entries_an_unknown() const {
    return unknowns > 0 ? static_cast<double>(entries) / static_cast<double>(unknowns) : 0;
  }
  [[nodiscard]] double products_an_unknown() const {
    return unknowns > 0 ? static_cast<double>(products) / static_cast<double>(unknowns) : 0;
  }
};

/// The cost of a square matrix with this pattern and its transpose's; LU on the diagonal has twice the entries and products. Values
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

/// The part of a pattern that belongs to `size` unknowns around the one in the middle, by breadth-first search.
template <class Scalar>
[[nodiscard]] Eigen::SparseMatrix<Scalar> neighbourhood(const Eigen::SparseMatrix<Scalar>& pattern, Eigen::Index size) {
  using Slot = typename Eigen::SparseMatrix<Scalar>::StorageIndex;
  const auto at = [](Eigen::Index k) { return static_cast<std::size_t>(k); };
  const Eigen::Index n = pattern.cols();
  std::vector<Slot> place(at(n), -1), found;
  const auto find = [&](Slot i) {
    if (place[at(i)] >= 0 || std::ssize(found) >= size) return;
    place[at(i)] = static_cast<Slot>(found.size());
    found.push_back(i);
  };
  Slot next = static_cast<Slot>(n / 2);  // where to go on if nothing is connected any more
  for (std::size_t k = 0; std::ssize(found) < std::min(size, n); ++k) {
    for (; k == found.size(); next = static_cast<Slot>((next + 1) % n)) find(next);
    for (Slot p = pattern.outerIndexPtr()[found[k]]; p < pattern.outerIndexPtr()[found[k] + 1]; ++p)
      find(pattern.innerIndexPtr()[p]);
  }
  std::sort(found.begin(), found.end());
  for (std::size_t k = 0; k < found.size(); ++k) place[at(found[k])] = static_cast<Slot>(k);
  std::vector<Eigen::Triplet<Scalar, Slot>> entries;
  for (std::size_t k = 0; k < found.size(); ++k)
    for (Slot p = pattern.outerIndexPtr()[found[k]]; p < pattern.outerIndexPtr()[found[k] + 1]; ++p)
      if (const Slot i = place[at(pattern.innerIndexPtr()[p])]; i >= 0)
        entries.emplace_back(i, static_cast<Slot>(k), Scalar{1});
  Eigen::SparseMatrix<Scalar> part(std::ssize(found), std::ssize(found));
  part.setFromTriplets(entries.begin(), entries.end());
  return part;
}

/// The same of 512 unknowns that are neighbours, of 1024, and so on, until is_enough(cost), or of all. Factors of a part of a
/// matrix have no more entries there than those of the whole: a field that is alike everywhere costs at least as much.
template <class Scalar>
[[nodiscard]] FactorCost factor_cost(const Eigen::SparseMatrix<Scalar>& pattern, auto&& is_enough) {
  for (Eigen::Index size = 512; 2 * size <= pattern.cols(); size *= 2)
    if (const FactorCost part = factor_cost(neighbourhood(pattern, size)); is_enough(part)) return part;
  return factor_cost(pattern);
}

}}  // namespace phistep::PHISTEP_ABI
