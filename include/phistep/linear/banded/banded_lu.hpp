/// @file
/// LU of a band matrix with row pivoting, in LAPACK's band storage.
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

/// resize(n, ℓ, u), fill column(j), factorize(), solve_in_place(x). Allocates in resize only.
template <class Scalar>
class BandedLu {
 public:
  using Index = Eigen::Index;

  void resize(Index n, Index lower, Index upper) {
    n_ = n, lower_ = lower, upper_ = upper, stride_ = 2 * lower + upper + 1;
    band_.assign(static_cast<std::size_t>(n * stride_), Scalar{0});
    inverse_pivot_.assign(static_cast<std::size_t>(n), Scalar{0});
    pivot_.assign(static_cast<std::size_t>(n), 0);
  }
  [[nodiscard]] Index rows() const { return n_; }
  [[nodiscard]] Index lower() const { return lower_; }
  [[nodiscard]] Index upper() const { return upper_; }

  /// All entries to zero, those that pivoting filled too.
  void clear() { std::fill(band_.begin(), band_.end(), Scalar{0}); }
  /// The diagonal entry of column j; the entry d rows below it is at [d], −u ≤ d ≤ ℓ.
  [[nodiscard]] Scalar* column(Index j) { return band_.data() + j * stride_ + lower_ + upper_; }
  [[nodiscard]] const Scalar* column(Index j) const { return band_.data() + j * stride_ + lower_ + upper_; }
  /// The matrix without room for fill: the entry (i, j) in row u + i − j, column j.
  [[nodiscard]] auto band() {
    using Stride = Eigen::OuterStride<>;
    return Eigen::Map<Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>, 0, Stride>(
        band_.data() + lower_, lower_ + upper_ + 1, n_, Stride(stride_));
  }

  /// False where a pivot is zero or not finite. The factors overwrite the matrix.
  [[nodiscard]] bool factorize() {
    width_ = 0;
    interchanged_ = false;
    Index last = 0;  // the last column that a pivot row reaches
    for (Index k = 0; k < n_; ++k) {
      Scalar* const below = column(k);
      const Index rows = std::min(lower_, n_ - 1 - k);
      Index pivot = 0;
      for (Index d = 1; d <= rows; ++d)
        if (std::abs(below[d]) > std::abs(below[pivot])) pivot = d;
      last = std::max(last, std::min(k + pivot + upper_, n_ - 1));
      width_ = std::max(width_, last - k);
      const Scalar inverse = Scalar{1} / below[pivot];
      // 1/∞ = 0 and 1/0 = ∞; a NaN that lost every comparison is below[0].
      if (!std::isfinite(inverse) || inverse == Scalar{0}) return false;
      pivot_[static_cast<std::size_t>(k)] = pivot;
      inverse_pivot_[static_cast<std::size_t>(k)] = inverse;
      interchanged_ = interchanged_ || pivot != 0;
      if (pivot != 0)
        for (Index c = 0; c <= last - k; ++c) {
          Scalar* const entry = below + c * (stride_ - 1);
          std::swap(entry[0], entry[pivot]);
        }
      for (Index d = 1; d <= rows; ++d) below[d] *= inverse;
      for (Index c = 1; c <= last - k; ++c) {
        Scalar* const entry = below + c * (stride_ - 1);
        const Scalar above = entry[0];
        for (Index d = 1; d <= rows; ++d) entry[d] -= below[d] * above;
      }
    }
    return true;
  }

  /// x ← W⁻¹ x
  void solve_in_place(auto&& vector) const {
    Scalar* const x = vector.data();
    if (!interchanged_ && lower_ == 1 && width_ == 1) return solve_narrow<1>(x);
    if (!interchanged_ && lower_ == 2 && width_ == 2) return solve_narrow<2>(x);
    for (Index k = 0; k < n_; ++k) {
      const Index pivot = pivot_[static_cast<std::size_t>(k)];
      if (pivot != 0) std::swap(x[k], x[k + pivot]);
      const Scalar* const below = column(k);
      const Index rows = std::min(lower_, n_ - 1 - k);
      const Scalar now = x[k];
      for (Index d = 1; d <= rows; ++d) x[k + d] -= below[d] * now;
    }
    for (Index k = n_ - 1; k >= 0; --k) {
      const Scalar* const above = column(k);
      const Scalar now = x[k] *= inverse_pivot_[static_cast<std::size_t>(k)];
      const Index rows = std::min(width_, k);
      for (Index d = 1; d <= rows; ++d) x[k - d] -= above[-d] * now;
    }
  }

 private:
  /// The same for w diagonals on either side and rows in their places: what was just computed stays in registers, where
  /// the loops above would wait for each store. Twice as fast for w = 1, three times for 2.
  template <int w>
  void solve_narrow(Scalar* x) const {
    const Scalar* const band = column(0);
    Scalar recent[w] = {};  // x[k−1], x[k−2] …
    const auto push = [&recent](Scalar now) {
      for (int d = w - 1; d > 0; --d) recent[d] = recent[d - 1];
      recent[0] = now;
    };
    for (Index k = 0; k < n_; ++k) {
      Scalar now = x[k];
      for (int d = w; d > 0; --d)
        if (d <= k) now -= band[(k - d) * stride_ + d] * recent[d - 1];
      push(x[k] = now);
    }
    for (Scalar& value : recent) value = Scalar{0};
    for (Index k = n_ - 1; k >= 0; --k) {
      Scalar now = x[k];
      for (int d = w; d > 0; --d)
        if (d < n_ - k) now -= band[(k + d) * stride_ - d] * recent[d - 1];
      push(x[k] = now * inverse_pivot_[static_cast<std::size_t>(k)]);
    }
  }

  Index n_ = 0, lower_ = 0, upper_ = 0, stride_ = 1;
  bool interchanged_ = false;
  Index width_ = 0;  // diagonals of U above the main one
  std::vector<Scalar> band_, inverse_pivot_;
  std::vector<Index> pivot_;  // the row that changed places with row k, counted from k
};

}}  // namespace phistep::PHISTEP_ABI
