/// @file
/// The places of a sparse matrix's entries, collected by counting: column by column, sorted, each once.
#pragma once

#include <Eigen/SparseCore>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A sparse matrix whose arrays stay in place when it is moved. Eigen 3.4 copies them, and its iterative solvers, which
/// refer to the arrays, would be left with freed ones.
template <class Scalar>
struct StayingMatrix : Eigen::SparseMatrix<Scalar> {
  StayingMatrix() = default;
  StayingMatrix(const StayingMatrix&) = default;
  StayingMatrix(StayingMatrix&& other) noexcept { this->swap(other); }
  StayingMatrix& operator=(const StayingMatrix&) = default;
  StayingMatrix& operator=(StayingMatrix&& other) noexcept {
    this->swap(other);
    return *this;
  }
  ~StayingMatrix() = default;
};

/// Of n × n.
class SparsePattern {
 public:
  using Index = Eigen::SparseMatrix<double>::StorageIndex;
  explicit SparsePattern(Eigen::Index n) : outer_(static_cast<std::size_t>(n) + 1, 0) {}

  /// @param each  each(add) calls add(i, j) for every place, in any order, the same one as often as it likes; twice the same
  void make(auto&& each) {
    std::fill(outer_.begin(), outer_.end(), 0);
    each([this](auto, auto j) { ++outer_[static_cast<std::size_t>(j) + 1]; });
    for (std::size_t j = 1; j < outer_.size(); ++j) outer_[j] += outer_[j - 1];
    inner_.resize(static_cast<std::size_t>(outer_.back()));
    each([this](auto i, auto j) {
      inner_[static_cast<std::size_t>(outer_[static_cast<std::size_t>(j)]++)] = static_cast<Index>(i);
    });
    // outer_[j] is the end of column j now.
    auto from = inner_.begin(), to = from;
    Index start = 0;
    for (std::size_t j = 0; j + 1 < outer_.size(); ++j) {
      const auto last = inner_.begin() + outer_[j];
      std::sort(from, last);
      to = std::unique_copy(from, last, to);
      from = last;
      outer_[j] = std::exchange(start, static_cast<Index>(to - inner_.begin()));
    }
    outer_.back() = start;
    inner_.resize(static_cast<std::size_t>(start));
  }
  /// To a matrix with these places, all zero.
  template <class Scalar>
  void give_to(Eigen::SparseMatrix<Scalar>& A) const {
    const auto n = static_cast<Eigen::Index>(outer_.size()) - 1;
    StayingMatrix<Scalar> made;  // one that runs out of memory on the way is good for nothing but its destructor
    made.resize(n, n);
    made.resizeNonZeros(static_cast<Eigen::Index>(inner_.size()));
    std::copy(outer_.begin(), outer_.end(), made.outerIndexPtr());
    std::copy(inner_.begin(), inner_.end(), made.innerIndexPtr());
    std::fill(made.valuePtr(), made.valuePtr() + made.nonZeros(), Scalar{0});
    A.swap(made);
  }

 private:
  std::vector<Index> outer_, inner_;
};

}}  // namespace phistep::PHISTEP_ABI
