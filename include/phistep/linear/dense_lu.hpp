/// @file
/// Dense LU with row pivoting that says so when a matrix is singular.
///
/// Eigen's PartialPivLU checks nothing (a singular matrix gives ±inf), and its blocked algorithm is slower than plain
/// loops whose bounds the compiler knows; so small fixed sizes get those loops, the rest Eigen behind one check.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include <cmath>
#include <utility>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Largest fixed size that is solved by plain unrolled loops.
inline constexpr int small_lu_limit = 16;

/// LU of an n×n matrix: resize(n), fill matrix(), factorize(), solve_in_place(x). Allocates nothing after construction for n ≤ 300.
template <class Scalar, int size>
class DenseLu {
 public:
  using Matrix = Eigen::Matrix<Scalar, size, size>;
  void resize(Eigen::Index n) {
    matrix_.resize(n, n);
    if constexpr (size == Eigen::Dynamic) lu_ = Eigen::PartialPivLU<Matrix>(n);
    permuted_.resize(n);
  }

  [[nodiscard]] Matrix& matrix() { return matrix_; }

  /// False where a pivot is zero or not finite.
  [[nodiscard]] bool factorize() {
    lu_.compute(matrix_);
    const auto pivots = lu_.matrixLU().diagonal().array().abs();
    // The sum finds NaN, which a minimum may step over.
    return matrix_.rows() == 0 || (pivots.minCoeff() > Scalar{0} && std::isfinite(pivots.sum()));
  }
  void solve_in_place(auto&& x) const {
    // By hand: Eigen's solve() into its own right-hand side makes a temporary.
    const auto& order = lu_.permutationP().indices();
    for (Eigen::Index i = 0; i < x.size(); ++i) permuted_[order[i]] = x[i];
    lu_.matrixLU().template triangularView<Eigen::UnitLower>().solveInPlace(permuted_);
    lu_.matrixLU().template triangularView<Eigen::Upper>().solveInPlace(permuted_);
    x = permuted_;
  }

 private:
  Matrix matrix_;
  Eigen::PartialPivLU<Matrix> lu_;
  mutable Eigen::Matrix<Scalar, size, 1> permuted_;
};

template <class Scalar, int size>
  requires(size != Eigen::Dynamic && size <= small_lu_limit)
class DenseLu<Scalar, size> {
 public:
  using Matrix = Eigen::Matrix<Scalar, size, size>;
  static void resize(Eigen::Index) {}

  [[nodiscard]] Matrix& matrix() { return lu_; }

  /// False where a pivot is zero or not finite. The factors overwrite matrix().
  [[nodiscard]] bool factorize() {
    for (int k = 0; k < size; ++k) {
      int pivot = k;
      for (int i = k + 1; i < size; ++i)
        if (std::abs(lu_(i, k)) > std::abs(lu_(pivot, k))) pivot = i;
      pivot_[k] = pivot;
      if (pivot != k)
        for (int j = 0; j < size; ++j) std::swap(lu_(k, j), lu_(pivot, j));
      if (!(std::abs(lu_(k, k)) > Scalar{0}) || !std::isfinite(lu_(k, k))) return false;
      inverse_pivot_[k] = Scalar{1} / lu_(k, k);
      for (int i = k + 1; i < size; ++i) lu_(i, k) *= inverse_pivot_[k];
      for (int j = k + 1; j < size; ++j)
        for (int i = k + 1; i < size; ++i) lu_(i, j) -= lu_(i, k) * lu_(k, j);
    }
    return true;
  }
  void solve_in_place(auto&& x) const {
    for (int k = 0; k < size; ++k)
      if (pivot_[k] != k) std::swap(x[k], x[pivot_[k]]);
    for (int j = 0; j < size; ++j)
      for (int i = j + 1; i < size; ++i) x[i] -= lu_(i, j) * x[j];
    for (int j = size - 1; j >= 0; --j) {
      x[j] *= inverse_pivot_[j];
      for (int i = 0; i < j; ++i) x[i] -= lu_(i, j) * x[j];
    }
  }

 private:
  // A stepper is copied before it has factorised anything: it must not read what was never written.
  Matrix lu_ = Matrix::Zero();
  Scalar inverse_pivot_[size]{};
  int pivot_[size]{};
};

}  // namespace phistep::inline PHISTEP_ABI
