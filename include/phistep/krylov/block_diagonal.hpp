/// @file
/// Preconditions by the blocks on W's diagonal, each inverted: those of several species that react at each point of a field, which
/// are unknowns size·k … size·k + size − 1 (Y. Saad, Iterative Methods for Sparse Linear Systems, 2nd ed., sect. 12.2).
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SparseCore>

#include <cstddef>
#include <vector>

#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// For `newton<PreconditionedGmres<BlockDiagonal<3>>>()`. The last block is smaller where the unknowns don't fill it.
template <int size, class Number = double>
class BlockDiagonal {
 public:
  using Scalar = Number;
  using Matrix = Eigen::SparseMatrix<Scalar>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  static_assert(size > 0);

  void analyzePattern(const Matrix& W) { blocks_.resize(static_cast<std::size_t>((W.cols() + size - 1) / size)); }
  void factorize(const Matrix& W) {
    for (Block& block : blocks_) block.setZero();
    for (Eigen::Index j = 0; j < W.cols(); ++j)
      for (typename Matrix::InnerIterator w(W, j); w; ++w)
        if (w.row() / size == j / size) at(j / size)(w.row() % size, j % size) = w.value();
    for (Eigen::Index j = W.cols(); j % size != 0; ++j) at(j / size)(j % size, j % size) = Scalar{1};
    is_regular_ = true;
    for (Block& block : blocks_) {
      block = block.inverse().eval();
      is_regular_ = is_regular_ && block.allFinite();
    }
  }
  void compute(const Matrix& W) {
    analyzePattern(W);
    factorize(W);
  }
  /// x ← P⁻¹ x
  void solve_in_place(Vector& x) const {
    const Eigen::Index full = x.size() / size, rest = x.size() % size;
    for (Eigen::Index k = 0; k < full; ++k) {
      const Eigen::Matrix<Scalar, size, 1> here = x.template segment<size>(k * size);
      x.template segment<size>(k * size).noalias() = at(k) * here;
    }
    if (rest == 0) return;
    Eigen::Matrix<Scalar, size, 1> last = Eigen::Matrix<Scalar, size, 1>::Zero();
    last.head(rest) = x.tail(rest);
    x.tail(rest) = (at(full) * last).eval().head(rest);
  }
  [[nodiscard]] Vector solve(Vector b) const {
    solve_in_place(b);
    return b;
  }
  /// NumericalIssue where a block is singular.
  [[nodiscard]] Eigen::ComputationInfo info() const { return is_regular_ ? Eigen::Success : Eigen::NumericalIssue; }

 private:
  using Block = Eigen::Matrix<Scalar, size, size>;
  [[nodiscard]] Block& at(Eigen::Index k) { return blocks_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const Block& at(Eigen::Index k) const { return blocks_[static_cast<std::size_t>(k)]; }

  std::vector<Block> blocks_;  // their inverses
  bool is_regular_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
