/// @file
/// Dense LU with row pivoting that says so when a matrix is singular: of sizes not known, or beyond 32, here; of few rows whose number
/// is known, in small_dense_lu.hpp.
///
/// Eigen's PartialPivLU checks nothing (a singular matrix gives ±inf), and its blocked algorithm is slower than plain loops on few
/// rows, more so where the compiler knows their number.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Largest fixed size with an elimination of its own, and most rows that are substituted by plain loops; beyond it, Eigen's.
inline constexpr int small_dense_limit = 32;

/// LU of an n×n matrix: resize(n), fill matrix(), factorize(), which is false where a pivot is zero, not finite or too small to have a
/// reciprocal and may overwrite matrix(), solve_in_place(x). Allocates nothing after construction for n ≤ 300. This one is Eigen's,
/// but plain loops for few rows, where Eigen's take up to twice as long.
template <class Scalar, int size>
class DenseLu {
  static_assert(size == Eigen::Dynamic || size > small_dense_limit, "phistep: small_dense_lu.hpp has these");

 public:
  using Matrix = Eigen::Matrix<Scalar, size, size>;
  void resize(Eigen::Index n) {
    matrix_.resize(n, n);
    if constexpr (size == Eigen::Dynamic) lu_ = Eigen::PartialPivLU<Matrix>(n);
    permuted_.resize(n);
    order_.resize(n);
    inverse_.resize(n);
  }

  [[nodiscard]] Matrix& matrix() { return matrix_; }

  [[nodiscard]] bool factorize() {
    if (is_of_few()) {
      eliminate();
    } else {
      lu_.compute(matrix_);
      for (int i = 0; i < matrix_.rows(); ++i) order_[lu_.permutationP().indices()[i]] = i;
    }
    inverse_ = lu().diagonal().cwiseInverse();
    const auto pivots = lu().diagonal().array().abs();
    // The sum finds NaN, which a minimum may step over.
    return matrix_.rows() == 0 || (std::isfinite(Scalar{1} / pivots.minCoeff()) && std::isfinite(pivots.sum()));
  }
  /// Smallest pivot beside the largest.
  [[nodiscard]] Scalar pivot_ratio() const {
    const auto pivots = lu().diagonal().array().abs();
    return matrix_.rows() == 0 ? Scalar{1} : pivots.minCoeff() / pivots.maxCoeff();
  }
  void solve_in_place(auto&& x) const {
    // By hand: Eigen's solve() into its own right-hand side makes a temporary.
    const Eigen::Index n = x.size();
    for (Eigen::Index i = 0; i < n; ++i) permuted_[i] = x[order_[i]];
    if (n <= small_dense_limit) {
      const Scalar* const a = lu().data();
      Scalar* const y = permuted_.data();
      for (Eigen::Index i = 1; i < n; ++i)
        for (Eigen::Index j = 0; j < i; ++j) y[i] -= a[i + j * n] * y[j];
      for (Eigen::Index i = n; i-- > 0;) {
        for (Eigen::Index j = n; --j > i;) y[i] -= a[i + j * n] * y[j];
        y[i] *= inverse_[i];
      }
    } else {
      lu().template triangularView<Eigen::UnitLower>().solveInPlace(permuted_);
      lu().template triangularView<Eigen::Upper>().solveInPlace(permuted_);
    }
    x = permuted_;
  }

 private:
  [[nodiscard]] bool is_of_few() const { return size == Eigen::Dynamic && matrix_.rows() <= 12; }
  [[nodiscard]] const Matrix& lu() const { return is_of_few() ? matrix_ : lu_.matrixLU(); }
  void eliminate() {
    const Eigen::Index n = matrix_.rows();
    std::iota(order_.data(), order_.data() + n, 0);
    for (Eigen::Index k = 0; k < n; ++k) {
      Scalar* const column = matrix_.data() + k * n;
      const Eigen::Index top =
          std::max_element(column + k, column + n, [](Scalar a, Scalar b) { return std::abs(a) < std::abs(b); }) -
          column;
      if (top != k) {
        for (Eigen::Index j = 0; j < n; ++j) std::swap(matrix_(k, j), matrix_(top, j));
        std::swap(order_[k], order_[top]);
      }
      const Scalar inverse = Scalar{1} / column[k];
      for (Eigen::Index i = k + 1; i < n; ++i) column[i] *= inverse;
      for (Eigen::Index j = k + 1; j < n; ++j) {
        Scalar* const other = matrix_.data() + j * n;
        for (Eigen::Index i = k + 1; i < n; ++i) other[i] -= column[i] * other[k];
      }
    }
  }

  Matrix matrix_;
  Eigen::PartialPivLU<Matrix> lu_;
  mutable Eigen::Matrix<Scalar, size, 1> permuted_;
  Eigen::Matrix<Scalar, size, 1> inverse_;
  Eigen::Matrix<int, size, 1> order_;
};

}}  // namespace phistep::PHISTEP_ABI
