/// @file
/// Block Thomas elimination: LU of a chain of b×b blocks, with pivoting inside the diagonal blocks alone.
///
///     D'_k = D_k − L_k G_{k−1},   G_k = D'_k⁻¹ U_k,   H_k = D'_k⁻¹ L_k
///     y_k = D'_k⁻¹ x_k − H_k y_{k−1},   x_k ← y_k − G_k x_{k+1}
///
/// (Golub & Van Loan, Matrix Computations, 4th ed., sect. 4.5.1). Each y waits for one small product only: with
/// D'_k⁻¹ (x_k − L_k y_{k−1}) instead, it waits for a product and a solve, one after the other, at three times the price.
///
/// Rows of different blocks never change places, so it is safe for block diagonally dominant matrices and not in general.
/// Its backward error is u‖D'_k‖(1 + ‖G_k‖ + ‖H_k‖) beside the block's row of W (Demmel, Higham & Schreiber, Numer. Linear
/// Algebra Appl. 2 (1995) 173): that growth is measured, and factorize() refuses a matrix where it costs more than a
/// quarter of the digits. A pivoted LU must then serve.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/linear/dense_lu.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// resize(blocks), fill lower(k), diagonal(k), upper(k), factorize(), solve_in_place(x). Allocates in resize only.
template <class Scalar, int b>
class BlockTridiagonalLu {
 public:
  static_assert(b > 0);
  using Index = Eigen::Index;
  using Block = Eigen::Matrix<Scalar, b, b>;

  void resize(Index blocks) {
    links_.resize(static_cast<std::size_t>(blocks));
    for (Link& link : links_) link.diagonal.resize(b);
  }
  [[nodiscard]] Index blocks() const { return static_cast<Index>(links_.size()); }

  /// W_{k,k−1}; k = 0 has none.
  [[nodiscard]] Block& lower(Index k) { return links_[static_cast<std::size_t>(k)].lower; }
  [[nodiscard]] Block& diagonal(Index k) { return links_[static_cast<std::size_t>(k)].diagonal.matrix(); }
  /// W_{k,k+1}; the last k has none.
  [[nodiscard]] Block& upper(Index k) { return links_[static_cast<std::size_t>(k)].upper; }

  /// False where a diagonal block is singular, or elimination lets the entries grow: that says nothing of W itself.
  /// The factors overwrite the blocks.
  [[nodiscard]] bool factorize() {
    static const Scalar limit = std::sqrt(std::sqrt(Scalar{1} / std::numeric_limits<Scalar>::epsilon()));
    const std::size_t count = links_.size();
    for (std::size_t k = 0; k < count; ++k) {
      Link& link = links_[k];
      Block& D = link.diagonal.matrix();
      Scalar row = size(D);
      if (k > 0) D.noalias() -= link.lower * links_[k - 1].upper;
      Scalar grown = size(D);
      if (!link.diagonal.factorize()) return false;
      Scalar reach{0};
      const auto divide = [&](Block& side) {
        row = std::max(row, size(side));
        for (int c = 0; c < b; ++c) link.diagonal.solve_in_place(side.col(c));
        reach += b * size(side);
      };
      if (k > 0) divide(link.lower);
      if (k + 1 < count) divide(link.upper);
      grown *= 1 + reach;
      if (!(reach <= limit && grown <= limit * row)) return false;  // a NaN too
    }
    return true;
  }

  /// x ← W⁻¹ x, b·blocks() components
  void solve_in_place(Scalar* x) const {
    const std::size_t count = links_.size();
    Scalar y[b]{};  // the neighbour's, in registers
    for (std::size_t k = 0; k < count; ++k, x += b) {
      links_[k].diagonal.solve_in_place(x);
      subtract_product(k > 0, links_[k].lower, x, y);
    }
    x -= b;
    for (std::size_t k = count; k-- > 1;) {
      x -= b;
      subtract_product(true, links_[k - 1].upper, x, y);
    }
  }

 private:
  struct Link {
    Block lower, upper;  // H and G after elimination
    DenseLu<Scalar, b> diagonal;
  };
  /// x ← x − A y, y ← x. Without a neighbour, A was never filled.
  static void subtract_product(bool has_neighbor, const Block& A, Scalar* x, Scalar* y) {
    Scalar sum[b];
    for (int i = 0; i < b; ++i) sum[i] = x[i];
    if (has_neighbor)
      for (int j = 0; j < b; ++j)
        for (int i = 0; i < b; ++i) sum[i] -= A(i, j) * y[j];
    for (int i = 0; i < b; ++i) x[i] = y[i] = sum[i];
  }
  [[nodiscard]] static Scalar size(const Block& A) {
    // The sum of squares would overflow, a maximum steps over NaN: pivots and solutions catch those.
    return A.cwiseAbs().maxCoeff();
  }

  std::vector<Link> links_;
};

}}  // namespace phistep::PHISTEP_ABI
