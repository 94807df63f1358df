/// @file
/// LU of several complex band matrices side by side, one a lane, as banded_lu.hpp does it for one: with ℓ diagonals below
/// and u above, about 2nℓ(ℓ+u) operations. Rows change places together (lane_pivot.hpp).
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "phistep/base/version.hpp"
#include "phistep/linear/lanes/complex_pack.hpp"
#include "phistep/linear/lanes/lane_pivot.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// resize(n, ℓ, u), clear(), fill column(j), factorize(), solve_in_place(x). Allocates in resize only.
template <class Scalar, int lanes>
class LaneBandedLu {
 public:
  using Index = Eigen::Index;
  using Number = ComplexPack<Scalar, lanes>;
  using Real = typename Number::Real;

  void resize(Index n, Index lower, Index upper) {
    n_ = n, lower_ = lower, upper_ = upper, stride_ = 2 * lower + upper + 1;
    band_.resize(static_cast<std::size_t>(n * stride_));
    pivot_.resize(static_cast<std::size_t>(n));
  }
  [[nodiscard]] Index rows() const { return n_; }
  [[nodiscard]] Index lower() const { return lower_; }
  [[nodiscard]] Index upper() const { return upper_; }

  /// All entries to zero, those that pivoting filled too.
  void clear() { std::fill(band_.begin(), band_.end(), zero()); }
  /// The diagonal entry of column j; the entry d rows below it is at [d], −u ≤ d ≤ ℓ.
  [[nodiscard]] Number* column(Index j) { return band_.data() + j * stride_ + lower_ + upper_; }
  [[nodiscard]] const Number* column(Index j) const { return band_.data() + j * stride_ + lower_ + upper_; }

  /// False where a pivot is zero or not finite. The factors overwrite the matrices, reciprocals their pivots.
  [[nodiscard]] bool factorize() {
    width_ = 0;
    Index last = 0;  // the last column that a pivot row reaches
    for (Index k = 0; k < n_; ++k) {
      Number* const below = column(k);
      const Index rows = std::min(lower_, n_ - 1 - k);
      const Index pivot = lane_pivot<Number>(rows + 1, [below](Index d) { return below[d]; });
      last = std::max(last, std::min(k + pivot + upper_, n_ - 1));
      width_ = std::max(width_, last - k);
      pivot_[static_cast<std::size_t>(k)] = pivot;
      if (!is_lane_pivot(below[pivot])) return false;
      if (pivot != 0)
        for (Index c = 0; c <= last - k; ++c) {
          Number* const entry = below + c * (stride_ - 1);
          std::swap(entry[0], entry[pivot]);
        }
      const Number inverse = below[0] = below[0].inverse();
      for (Index d = 1; d <= rows; ++d) below[d] = below[d] * inverse;
      for (Index c = 1; c <= last - k; ++c) {
        Number* const entry = below + c * (stride_ - 1);
        const Number above = entry[0];
        for (Index d = 1; d <= rows; ++d) entry[d].subtract(below[d], above);
      }
    }
    return true;
  }

  /// x ← W⁻¹ x
  void solve_in_place(Number* x) const {
    for (Index k = 0; k < n_; ++k) {
      const Index pivot = pivot_[static_cast<std::size_t>(k)];
      if (pivot != 0) std::swap(x[k], x[k + pivot]);
      const Number* const below = column(k);
      const Index rows = std::min(lower_, n_ - 1 - k);
      const Number now = x[k];
      for (Index d = 1; d <= rows; ++d) x[k + d].subtract(below[d], now);
    }
    for (Index k = n_ - 1; k >= 0; --k) {
      const Number* const above = column(k);
      const Number now = x[k] = x[k] * above[0];
      const Index rows = std::min(width_, k);
      for (Index d = 1; d <= rows; ++d) x[k - d].subtract(above[-d], now);
    }
  }

 private:
  [[nodiscard]] static Number zero() { return {Real{Scalar{0}}, Real{Scalar{0}}}; }

  Index n_ = 0, lower_ = 0, upper_ = 0, stride_ = 1;
  Index width_ = 0;  // diagonals of U above the main one
  std::vector<Number> band_;
  std::vector<Index> pivot_;  // the row that changed places with row k, counted from k
};

}}  // namespace phistep::PHISTEP_ABI
