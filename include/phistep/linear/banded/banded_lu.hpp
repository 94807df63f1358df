/// @file
/// LU of a band matrix with row pivoting, in LAPACK's band storage; of numbers, or of several complex ones side by side
/// (linear/lanes/complex_pack.hpp).
///
/// With ℓ diagonals below and u above, P W = L U has multipliers within ℓ of the diagonal and, rows having changed places,
/// U within ℓ + u: about 2nℓ(ℓ+u) operations, and n(4ℓ+2u) a solve (Golub & Van Loan, Matrix Computations, 4th ed.,
/// sect. 4.3; LAPACK's xGBTF2). Column j is stored from row j − ℓ − u to row j + ℓ.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What an elimination asks of its numbers, here of single ones. The row of a column that is to be the pivot's: the largest,
/// the first of equals.
template <class Scalar>
[[nodiscard]] Eigen::Index pivot_row(const Scalar* column, Eigen::Index rows) {
  Eigen::Index pivot = 0;
  for (Eigen::Index d = 1; d < rows; ++d)
    if (std::abs(column[d]) > std::abs(column[pivot]))
        [[unlikely]]  // a branch: one that is predicted waits for nothing
      pivot = d;
  return pivot;
}
/// x ← 1/x. False where x is zero or not finite: 1/∞ = 0 and 1/0 = ∞.
template <class Scalar>
[[nodiscard]] bool invert(Scalar& x) {
  x = Scalar{1} / x;
  return std::isfinite(x) && x != Scalar{0};
}
/// to −= a b
template <class Scalar>
void subtract_product(Scalar& to, const Scalar& a, const Scalar& b) {
  to -= a * b;
}
/// to −= x by, of columns. A function: in the loops around it, g++ -O2 took 1.3 times as long.
template <class Number>
void subtract_multiple(Number* to, const Number* x, Eigen::Index rows, Number by) {
  for (Eigen::Index d = 0; d < rows; ++d) subtract_product(to[d], x[d], by);
}
/// Whether multiples of x need not be subtracted. For single numbers always false: the test costs as much as it saves.
template <class Scalar>
[[nodiscard]] bool is_known_zero(const Scalar& /*x*/) {
  return false;
}

/// resize(n, ℓ, u), fill column(j), factorize(), solve_in_place(x). Allocates in resize only.
/// @tparam few  the rows of a full matrix, where there are so few that loops of known length are shorter
template <class Number, int few = Eigen::Dynamic>
class BandedLu {
  static constexpr bool is_few = few != Eigen::Dynamic;

 public:
  using Index = Eigen::Index;

  void resize(Index n, Index lower, Index upper) { reserve(n, lower, upper, 2 * lower + upper + 1, lower + upper); }
  /// A full matrix, with no room beside it: its columns follow one another.
  void resize(Index n) { reserve(n, n - 1, n - 1, n + 1, 0); }
  [[nodiscard]] Index rows() const { return is_few ? few : n_; }
  [[nodiscard]] Index lower() const { return is_few ? few - 1 : lower_; }
  [[nodiscard]] Index upper() const { return upper_; }

  /// All entries to zero, those that pivoting filled too.
  void clear() { std::fill(band_.begin(), band_.end(), Number{}); }
  /// The diagonal entry of column j; the entry d rows below it is at [d], −u ≤ d ≤ ℓ.
  [[nodiscard]] Number* column(Index j) { return band_.data() + j * stride_ + origin_; }
  [[nodiscard]] const Number* column(Index j) const { return band_.data() + j * stride_ + origin_; }
  /// The matrix without room for fill: the entry (i, j) in row u + i − j, column j.
  [[nodiscard]] auto band() {
    using Stride = Eigen::OuterStride<>;
    return Eigen::Map<Eigen::Matrix<Number, Eigen::Dynamic, Eigen::Dynamic>, 0, Stride>(
        band_.data() + lower_, lower_ + upper_ + 1, n_, Stride(stride_));
  }

  /// False where a pivot is zero or not finite. The factors overwrite the matrix, reciprocals the pivots.
  [[nodiscard]] bool factorize() {
    const Index n = this->rows(), lower = this->lower(), stride = is_few ? few + 1 : stride_;
    width_ = 0;
    interchanged_ = false;
    Index last = 0;  // the last column that a pivot row reaches
    for (Index k = 0; k < n; ++k) {
      Number* const below = column(k);
      const Index rows = std::min(lower, n - 1 - k);
      const Index pivot = pivot_row(below, rows + 1);
      last = std::max(last, std::min(k + pivot + upper_, n - 1));
      width_ = std::max(width_, last - k);
      Number inverse = below[pivot];
      if (!invert(inverse)) return false;  // a NaN that lost every comparison is below[0]
      pivot_[static_cast<std::size_t>(k)] = pivot;
      interchanged_ = interchanged_ || pivot != 0;
      if (pivot != 0)
        for (Index c = 0; c <= last - k; ++c) {
          Number* const entry = below + c * (stride - 1);
          std::swap(entry[0], entry[pivot]);
        }
      below[0] = inverse;
      for (Index d = 1; d <= rows; ++d) below[d] = below[d] * inverse;
      for (Index c = 1; c <= last - k; ++c) {
        Number* const entry = below + c * (stride - 1);
        const Number above = entry[0];
        if (is_known_zero(above)) continue;
        subtract_multiple(entry + 1, below + 1, rows, above);
      }
    }
    return true;
  }

  /// x ← W⁻¹ x
  void solve_in_place(auto&& vector) const {
    Number* const x = vector.data();
    const Index n = this->rows(), lower = this->lower(), width = is_few ? few - 1 : width_;
    if (!is_few && !interchanged_ && lower == 1 && width == 1) return solve_narrow<1>(x);
    if (!is_few && !interchanged_ && lower == 2 && width == 2) return solve_narrow<2>(x);
    for (Index k = 0; k < n; ++k) {
      const Index pivot = pivot_[static_cast<std::size_t>(k)];
      if (pivot != 0) std::swap(x[k], x[k + pivot]);
      const Number* const below = column(k);
      const Index rows = std::min(lower, n - 1 - k);
      const Number now = x[k];
      for (Index d = 1; d <= rows; ++d) subtract_product(x[k + d], below[d], now);
    }
    for (Index k = n - 1; k >= 0; --k) {
      const Number* const above = column(k);
      const Number now = x[k] = x[k] * above[0];
      const Index rows = std::min(width, k);
      for (Index d = 1; d <= rows; ++d) subtract_product(x[k - d], above[-d], now);
    }
  }

 private:
  void reserve(Index n, Index lower, Index upper, Index stride, Index origin) {
    n_ = n, lower_ = lower, upper_ = upper, stride_ = stride, origin_ = origin;
    band_.assign(static_cast<std::size_t>(n * stride_), Number{});
    pivot_.assign(static_cast<std::size_t>(n), 0);
  }
  /// The same for w diagonals on either side and rows in their places: what was just computed stays in registers, where
  /// the loops above would wait for each store. Twice as fast for w = 1, three times for 2.
  template <int w>
  void solve_narrow(Number* x) const {
    const Number* const band = column(0);
    Number recent[w] = {};  // x[k−1], x[k−2] …
    const auto push = [&recent](Number now) {
      for (int d = w - 1; d > 0; --d) recent[d] = recent[d - 1];
      recent[0] = now;
    };
    for (Index k = 0; k < n_; ++k) {
      Number now = x[k];
      for (int d = w; d > 0; --d)
        if (d <= k) subtract_product(now, band[(k - d) * stride_ + d], recent[d - 1]);
      push(x[k] = now);
    }
    for (Number& value : recent) value = Number{};
    for (Index k = n_ - 1; k >= 0; --k) {
      Number now = x[k];
      for (int d = w; d > 0; --d)
        if (d < n_ - k) subtract_product(now, band[(k + d) * stride_ - d], recent[d - 1]);
      push(x[k] = now * band[k * stride_]);
    }
  }

  Index n_ = 0, lower_ = 0, upper_ = 0, stride_ = 1, origin_ = 0;
  bool interchanged_ = false;
  Index width_ = 0;  // diagonals of U above the main one
  std::vector<Number> band_;
  std::vector<Index> pivot_;  // the row that changed places with row k, counted from k
};

}}  // namespace phistep::PHISTEP_ABI
