/// @file
/// Incomplete Cholesky factors L D Lᵀ ≈ W of a symmetric W on W's own pattern, whose dropped fill is added to the diagonal
/// (I. Gustafsson, BIT 18 (1978) 142): on grids, conjugate gradients need iterations like the fourth root of their
/// unknowns in two dimensions, in place of the square root, and fewer than with factors that simply drop.
///
///     d_j = w_jj,   l_ij = w_ij / d_j,   w_ik ← w_ik − l_ij d_j l_kj     for i ≥ k > j                              (1)
///
/// and where W has no entry (i, k): w_ii and w_kk ← … − ω l_ij d_j l_kj, with ω = 0.98. A pivot that falls below a hundredth of
/// W's own (W is no M-matrix, say) is replaced by W's.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// W's incomplete Cholesky factors on its own pattern, dropped fill added to the diagonal, for grids:
/// newton<PreconditionedCg<ModifiedIncompleteCholesky<>>>()
/// @tparam Number  of the factors
template <class Number = double>
class ModifiedIncompleteCholesky {
 public:
  using Scalar = Number;
  using Matrix = Eigen::SparseMatrix<Scalar>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  static constexpr Scalar omega = Scalar{98} / 100;

  /// The lower triangle's pattern.
  void analyzePattern(const Matrix& W) {
    start_.assign(1, 0);
    row_.clear();
    for (Eigen::Index j = 0; j < W.cols(); ++j) {
      for (typename Matrix::InnerIterator w(W, j); w; ++w)
        if (w.row() > j) row_.push_back(static_cast<int>(w.row()));
      start_.push_back(static_cast<int>(row_.size()));
    }
    l_.resize(row_.size());
    inverse_.setZero(W.cols());
  }
  void factorize(const Matrix& W) {
    read(W);
    const auto n = static_cast<int>(inverse_.size());
    is_definite_ = true;
    for (int j = 0; j < n; ++j) {
      const Scalar own = W.coeff(j, j);
      is_definite_ = is_definite_ && own > Scalar{0};
      Scalar& d = inverse_[j];
      if (!(d > own / 100)) d = own;
      for (int p = start_[at(j)]; p < start_[at(j + 1)]; ++p) {
        const Scalar l = l_[at(p)] / d;
        const int k = row_[at(p)];
        inverse_[k] -= l * l_[at(p)];
        for (int q = p + 1; q < start_[at(j + 1)]; ++q) subtract(row_[at(q)], k, l * l_[at(q)]);
      }
      d = 1 / d;
      for (int p = start_[at(j)]; p < start_[at(j + 1)]; ++p) l_[at(p)] *= d;
    }
  }
  void compute(const Matrix& W) {
    analyzePattern(W);
    factorize(W);
  }
  /// x ← (L D Lᵀ)⁻¹ x
  void solve_in_place(Vector& x) const {
    const auto n = static_cast<int>(inverse_.size());
    for (int j = 0; j < n; ++j) {
      const Scalar here = x[j];
      for (int p = start_[at(j)]; p < start_[at(j + 1)]; ++p) x[row_[at(p)]] -= l_[at(p)] * here;
    }
    for (int j = n - 1; j >= 0; --j) {
      Scalar here = x[j] * inverse_[j];
      for (int p = start_[at(j + 1)]; p-- > start_[at(j)];) here -= l_[at(p)] * x[row_[at(p)]];
      x[j] = here;
    }
  }
  [[nodiscard]] Vector solve(Vector b) const {
    solve_in_place(b);
    return b;
  }
  [[nodiscard]] Eigen::ComputationInfo info() const { return is_definite_ ? Eigen::Success : Eigen::NumericalIssue; }

 private:
  [[nodiscard]] static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  void read(const Matrix& W) {
    std::size_t p = 0;
    for (Eigen::Index j = 0; j < W.cols(); ++j)
      for (typename Matrix::InnerIterator w(W, j); w; ++w) {
        if (w.row() == j) inverse_[j] = w.value();
        else if (w.row() > j) l_[p++] = w.value();
      }
  }
  /// w_ik −= x; where the pattern has no such entry, both diagonal entries take omega x instead.
  void subtract(int i, int k, Scalar x) {
    const auto first = row_.begin() + start_[at(k)], last = row_.begin() + start_[at(k + 1)];
    const auto place = std::lower_bound(first, last, i);
    if (place != last && *place == i) {
      l_[static_cast<std::size_t>(place - row_.begin())] -= x;
    } else {
      inverse_[i] -= omega * x;
      inverse_[k] -= omega * x;
    }
  }

  std::vector<int> start_, row_;  // below the diagonal, by columns
  std::vector<Scalar> l_;
  Vector inverse_;  // D until it is done, then 1/D
  bool is_definite_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
