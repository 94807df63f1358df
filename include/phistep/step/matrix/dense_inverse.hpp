/// @file
/// The explicit inverse of a small dense matrix, by Gauss-Jordan elimination in place with row pivoting.
///
/// It takes 2-3 times as long to make as LU, but then a solve is a product, whose rows don't wait for each other.
/// Its residual is that of pivoted elimination for one right-hand side but grows with the condition number κ:
/// ‖A x − b‖ ≤ c n u κ ‖A‖ ‖x‖ (Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., sect. 14.1 and 14.4).
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <utility>

#include "phistep/base/version.hpp"
#include "phistep/step/matrix/column.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Inverse of an n×n matrix, n ≤ 32: fill matrix(), factorize(), solve_in_place(x). Allocates nothing.
template <class Scalar, int size>
  requires(size != Eigen::Dynamic && size <= small_dense_limit)
class DenseInverse {
 public:
  using Matrix = Eigen::Matrix<Scalar, size, size>;
  static void resize(Eigen::Index) {}

  [[nodiscard]] Matrix& matrix() { return a_; }

  /// False where a pivot is zero, not finite or too small to have a reciprocal. The inverse overwrites matrix().
  [[nodiscard]] bool factorize() {
    Scalar reciprocal[size];
    int pivots[size];
    if constexpr (size <= 3) invert(reciprocal, pivots);
    else invert(reciprocal, pivots, std::make_integer_sequence<int, size>{});
    return all_invertible(reciprocal);
  }

  [[gnu::always_inline]] void solve_in_place(auto&& x) const {
    const Scalar* const a = a_.data();
    using Sum = Column<Scalar, size>;
    // Few packs would wait for their own last addition: two sums then.
    constexpr int sums = size > 3 && Sum::packs <= 4 ? 2 : 1;
    Sum even(a);
    even.scale(x[0]);
    if constexpr (sums == 2) {
      Sum odd(a + size);
      odd.scale(x[1]);
      for (int j = 2; j + 1 < size; j += 2) {
        even.add(x[j], Sum(a + j * size));
        odd.add(x[j + 1], Sum(a + (j + 1) * size));
      }
      if constexpr (size % 2 == 1) even.add(x[size - 1], Sum(a + (size - 1) * size));
      even.add(odd);
    } else {
      for (int j = 1; j < size; ++j) even.add(x[j], Sum(a + j * size));
    }
    Scalar beside[size];
    even.store(beside);
    for (int i = 0; i < size; ++i) x[i] = beside[i];
  }

 private:
  void exchange(int i, int j) {
    Scalar* const a = a_.data();
    for (int column = 0; column < size; ++column) std::swap(a[i + column * size], a[j + column * size]);
  }

  // Step k solves row k for its unknown: with p = a_kk, column k becomes f, f_k = 1/p, f_i = −a_ik/p, and every other
  // column j, its a_kj put aside and set to zero, receives a_kj f.
  // Up to 3 rows lie in registers, copied number by number.
  void invert(Scalar (&reciprocals)[size], int (&pivots)[size]) {
    using std::abs;
    Scalar a[size][size];  // by columns
    unrolled<size>([&](auto j) { unrolled<size>([&](auto i) { a[j][i] = a_.data()[i + j * size]; }); });
    unrolled<size>([&](auto k) {
      pivots[k] = k;
      unrolled<size>([&](auto i) {
        if (i > k && abs(a[k][i]) > abs(a[k][pivots[k]])) pivots[k] = i;
      });
      unrolled<size>([&](auto i) {
        if (i > k && i == pivots[k]) unrolled<size>([&](auto j) { std::swap(a[j][i], a[j][k]); });
      });
      const Scalar inverse = reciprocals[k] = Scalar{1} / a[k][k];
      unrolled<size>([&](auto i) { a[k][i] *= i == k ? Scalar{0} : -inverse; });
      a[k][k] = inverse;
      unrolled<size>([&](auto j) {
        if (j == k) return;
        const Scalar u = a[j][k];
        unrolled<size>([&](auto i) { a[j][i] = (i == k ? Scalar{0} : a[j][i]) + a[k][i] * u; });
      });
    });
    unrolled<size>([&](auto back) {
      const auto k = size - 1 - back;
      unrolled<size>([&](auto j) {
        if (j > k && j == pivots[k]) unrolled<size>([&](auto i) { std::swap(a[k][i], a[j][i]); });
      });
    });
    unrolled<size>([&](auto j) { unrolled<size>([&](auto i) { a_.data()[i + j * size] = a[j][i]; }); });
  }

  template <int... k>
  void invert(Scalar (&reciprocal)[size], int (&pivots)[size], std::integer_sequence<int, k...>) {
    int pivot = Column<Scalar, size>(a_.data()).largest();
    (invert_column<k>(reciprocal, pivots, pivot), ...);
    // The inverse of the matrix with its rows exchanged: its columns go back, last exchange first.
    for (int i = size - 1; i >= 0; --i)
      if (pivots[i] != i) a_.col(i).swap(a_.col(pivots[i]));
  }
  // A function for each k: inlined into one, g++ -O2 gives up on the registers.
  template <int k>
  void invert_column(Scalar (&reciprocal)[size], int (&pivots)[size], int& pivot) {
    using Whole = Column<Scalar, size>;
    Scalar* const a = a_.data();
    pivots[k] = pivot;
    if (pivot != k) exchange(k, pivot);
    const Scalar inverse = reciprocal[k] = Scalar{1} / a[k + k * size];
    Whole f(a + k * size);
    f.scale(-inverse);
    f.template set<k>(inverse);
    f.store(a + k * size);
    // The next pivot's column first: its search then runs beside the rest of the elimination.
    if constexpr (k + 1 < size) {
      Scalar* const column = a + (k + 1) * size;
      Whole next(column);
      const Scalar u = column[k];
      next.template set<k>(Scalar{0});
      next.add(u, f);
      next.store(column);
      pivot = next.template largest<k + 1>();
    }
    for (int j = 0; j < size; ++j) {
      if (j == k || j == k + 1) continue;
      Scalar* const column = a + j * size;
      Whole other(column);
      const Scalar u = column[k];
      other.template set<k>(Scalar{0});
      other.add(u, f);
      other.store(column);
    }
  }

  Matrix a_ = Matrix::Zero();  // a stepper is copied before it has factorized anything
};

}}  // namespace phistep::PHISTEP_ABI
