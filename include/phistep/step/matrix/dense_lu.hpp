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

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/matrix/column.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

  /// False where a pivot is zero, not finite or too small to have a reciprocal.
  [[nodiscard]] bool factorize() {
    lu_.compute(matrix_);
    const auto pivots = lu_.matrixLU().diagonal().array().abs();
    // The sum finds NaN, which a minimum may step over.
    return matrix_.rows() == 0 || (std::isfinite(Scalar{1} / pivots.minCoeff()) && std::isfinite(pivots.sum()));
  }
  /// Smallest pivot beside the largest.
  [[nodiscard]] Scalar pivot_ratio() const {
    const auto pivots = lu_.matrixLU().diagonal().array().abs();
    return matrix_.rows() == 0 ? Scalar{1} : pivots.minCoeff() / pivots.maxCoeff();
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
  requires(size > 3 && size <= small_dense_limit)
class DenseLu<Scalar, size> {
 public:
  using Matrix = Eigen::Matrix<Scalar, size, size>;
  static void resize(Eigen::Index) {}

  [[nodiscard]] Matrix& matrix() { return lu_; }

  /// False where a pivot is zero, not finite or too small to have a reciprocal. The factors overwrite matrix().
  [[nodiscard]] bool factorize() {
    for (int i = 0; i < size; ++i) order_[i] = i;
    eliminate(std::make_integer_sequence<int, size>{});
    return all_invertible(inverse_pivot_);
  }

  void solve_in_place(auto&& x) const {
    Scalar y[size];
    for (int i = 0; i < size; ++i) y[i] = x[order_[i]];
    substitute(y, std::make_integer_sequence<int, size>{});
    for (int i = 0; i < size; ++i) x[i] = y[i];
  }

 private:
  // Row by row: the sum over older y runs ahead, so that only one product of each row waits for the newest.
  template <int... i>
  [[gnu::always_inline]] void substitute(Scalar* y, std::integer_sequence<int, i...>) const {
    (forward<i>(y, std::make_integer_sequence<int, i>{}), ...);
    (back<size - 1 - i>(y, std::make_integer_sequence<int, i>{}), ...);
  }
  template <int row, int... j>
  [[gnu::always_inline]] void forward(Scalar* y, std::integer_sequence<int, j...>) const {
    [[maybe_unused]] const Scalar* const a = lu_.data() + row;
    Scalar sum = y[row];
    ((sum -= a[j * size] * y[j]), ...);
    y[row] = sum;
  }
  template <int row, int... later>
  [[gnu::always_inline]] void back(Scalar* y, std::integer_sequence<int, later...>) const {
    [[maybe_unused]] const Scalar* const a = lu_.data() + row;
    Scalar sum = y[row];
    ((sum -= a[(size - 1 - later) * size] * y[size - 1 - later]), ...);
    y[row] = sum * inverse_pivot_[row];
  }

  void exchange(int i, int j) {
    Scalar* const a = lu_.data();
    for (int column = 0; column < size; ++column) std::swap(a[i + column * size], a[j + column * size]);
    std::swap(order_[i], order_[j]);
  }

  template <int... k>
  void eliminate(std::integer_sequence<int, k...>) {
    int pivot = Column<Scalar, size>(lu_.data()).largest();
    (eliminate_column<k>(pivot), ...);
  }
  // A function for each k: inlined into one, g++ -O2 gives up on the registers.
  template <int k>
  void eliminate_column(int& pivot) {
    if (pivot != k) exchange(k, pivot);
    Scalar* column = lu_.data() + k * size;
    const Scalar inverse = inverse_pivot_[k] = Scalar{1} / column[k];
    if constexpr (k + 1 < size) {
      using Below = Column<Scalar, size, k + 1>;
      Below factors(column);
      factors.scale(inverse);
      factors.store_below(column);
      factors.clear_above();
      column += size;
      // The next pivot's column first: its search then runs beside the rest of the elimination.
      Below next(column);
      next.add(-column[k], factors);
      next.store(column);
      pivot = next.largest();
      for (int j = k + 2; j < size; ++j) {
        column += size;
        Below other(column);
        other.add(-column[k], factors);
        other.store(column);
      }
    }
  }

  // A stepper is copied before it has factorized anything: it must not read what was never written.
  Matrix lu_ = Matrix::Zero();
  Scalar inverse_pivot_[size]{};
  int order_[size]{};
};

/// Up to 3 rows lie in registers. What a solve waits for counts there, not how many operations it has: with L⁻¹P made
/// explicit (its entries are at most 2, PA = LU having |L| ≤ 1) and the pivots divided out of U, it is a product and one
/// addition for each row. As accurate as LU, which the inverse of A is not.
template <class Scalar, int size>
  requires(size >= 1 && size <= 3)
class DenseLu<Scalar, size> {
 public:
  using Matrix = Eigen::Matrix<Scalar, size, size>;
  static void resize(Eigen::Index) {}

  [[nodiscard]] Matrix& matrix() { return a_; }

  /// False where a pivot is zero, not finite or too small to have a reciprocal. The factors overwrite matrix().
  [[nodiscard]] bool factorize() {
    using std::abs;
    Scalar a[size][size], inverse[size];
    int order[size], top = 0;
    unrolled<size>([&](auto i) {
      if (abs(at(i, 0)) > abs(at(top, 0))) top = i;
    });
    // The first exchange is made by the copy.
    unrolled<size>([&](auto i) {
      order[i] = i == 0 ? top : i == top ? 0 : int{i};
      unrolled<size>([&](auto j) { a[i][j] = at(order[i], j); });
    });
    unrolled<size>([&](auto k) {
      if constexpr (k == 1 && size == 3)
        if (abs(a[2][1]) > abs(a[1][1])) {
          unrolled<size>([&](auto j) { std::swap(a[1][j], a[2][j]); });
          std::swap(order[1], order[2]);
        }
      inverse[k] = Scalar{1} / a[k][k];
      unrolled<size>([&](auto i) {
        if constexpr (i > k) {
          a[i][k] *= inverse[k];
          unrolled<size>([&](auto j) {
            if constexpr (j > k) a[i][j] -= a[i][k] * a[k][j];
          });
        }
      });
    });
    unrolled<size>([&](auto i) { unrolled<size>([&](auto j) { at(i, j) = Scalar{0}; }); });
    at(0, order[0]) = inverse[0];
    if constexpr (size > 1) {
      at(1, order[1]) = inverse[1];
      at(1, order[0]) = -a[1][0] * inverse[1];
      upper_[0] = a[0][1] * inverse[0];
    }
    if constexpr (size > 2) {
      at(2, order[2]) = inverse[2];
      at(2, order[1]) = -a[2][1] * inverse[2];
      at(2, order[0]) = (a[2][1] * a[1][0] - a[2][0]) * inverse[2];
      upper_[1] = a[0][2] * inverse[0];
      upper_[2] = a[1][2] * inverse[1];
    }
    return all_invertible(inverse);
  }

  void solve_in_place(auto&& x) const {
    // `fma`, not left to the compiler, which would round once here and twice there, wherever x lies.
    Scalar y[size];
    unrolled<size>([&](auto i) {
      y[i] = at(i, 0) * x[0];
      if constexpr (size > 1) y[i] = fma(at(i, 1), x[1], y[i]);
      if constexpr (size > 2) y[i] = fma(at(i, 2), x[2], y[i]);
    });
    if constexpr (size > 2) {
      y[1] = fma(-upper_[2], y[2], y[1]);
      y[0] = fma(-upper_[1], y[2], y[0]);
    }
    if constexpr (size > 1) y[0] = fma(-upper_[0], y[1], y[0]);
    unrolled<size>([&](auto i) { x[int{i}] = y[i]; });
  }

 private:
  [[nodiscard]] Scalar& at(int i, int j) { return a_.data()[i + j * size]; }
  [[nodiscard]] Scalar at(int i, int j) const { return a_.data()[i + j * size]; }

  // A stepper is copied before it has factorized anything: it must not read what was never written.
  Matrix a_ = Matrix::Zero();  // D⁻¹L⁻¹P, D the diagonal of U
  Scalar upper_[3]{};          // D⁻¹U at (0,1), (0,2), (1,2)
};

}}  // namespace phistep::PHISTEP_ABI
