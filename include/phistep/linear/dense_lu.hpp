/// @file
/// Dense LU with row pivoting that says so when a matrix is singular.
///
/// Eigen's PartialPivLU checks nothing (a singular matrix gives ±inf), and its blocked algorithm is slower than plain
/// loops whose bounds the compiler knows; so small fixed sizes get those loops, the rest Eigen behind one check.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include <cmath>
#include <limits>
#include <utility>

#include "phistep/core/version.hpp"
#include "phistep/linear/column.hpp"

namespace phistep::inline PHISTEP_ABI {

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
  requires(size != Eigen::Dynamic && size <= small_dense_limit)
class DenseLu<Scalar, size> {
 public:
  using Matrix = Eigen::Matrix<Scalar, size, size>;
  static void resize(Eigen::Index) {}

  [[nodiscard]] Matrix& matrix() { return lu_; }

  /// False where a pivot is zero, not finite or too small to have a reciprocal. The factors overwrite matrix().
  [[nodiscard]] bool factorize() {
    for (int i = 0; i < size; ++i) order_[i] = i;
    // Up to 3 rows, packets gain nothing.
    if constexpr (size > 3 && has_columns<Scalar>) eliminate_columns(std::make_integer_sequence<int, size>{});
    else eliminate();
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

  void eliminate() {
    using std::abs;
    // Up to 3 rows lie in registers, copied number by number; of 3, the first exchange is made by the copy.
    constexpr int beside = size <= 3 ? size : 0;
    constexpr bool gathers = size == 3;
    Scalar copy[beside * beside + 1];
    [[maybe_unused]] int top = 0;
    if constexpr (gathers)
      unrolled<beside>([&](auto i) {
        if (abs(lu_.data()[i]) > abs(lu_.data()[top])) top = i;
      });
    unrolled<beside>([&](auto i) {
      const int from = i == 0 ? top : i == top ? 0 : int{i};
      unrolled<beside>([&](auto j) { copy[i + j * size] = lu_.data()[from + j * size]; });
      order_[i] = from;
    });
    Scalar* const a = beside > 0 ? copy : lu_.data();
    each<size>([&](auto k) {
      each<size>([&](auto i) {
        if (i <= k || (gathers && k == 0) || !(abs(a[i + k * size]) > abs(a[k + k * size]))) return;
        each<size>([&](auto j) { std::swap(a[i + j * size], a[k + j * size]); });
        std::swap(order_[i], order_[k]);
      });
      const Scalar inverse = inverse_pivot_[k] = Scalar{1} / a[k + k * size];
      each<size>([&](auto i) {
        if (i > k) a[i + k * size] *= inverse;
      });
      each<size>([&](auto j) {
        if (j <= k) return;
        each<size>([&](auto i) {
          if (i > k) a[i + j * size] -= a[i + k * size] * a[k + j * size];
        });
      });
    });
    unrolled<beside * beside>([&](auto i) { lu_.data()[i] = copy[i]; });
  }

  template <int... k>
  void eliminate_columns(std::integer_sequence<int, k...>) {
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

  // A stepper is copied before it has factorised anything: it must not read what was never written.
  Matrix lu_ = Matrix::Zero();
  Scalar inverse_pivot_[size]{};
  int order_[size]{};
};

}  // namespace phistep::inline PHISTEP_ABI
