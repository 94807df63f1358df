/// @file
/// G with M G M = M for a singular M, by a QR decomposition with column pivoting (Golub & Van Loan, Matrix Computations,
/// 4th ed., sect. 5.4.2 and 5.5.7): M P = Q (R₁ R₂; 0 0), G = P (R₁⁻¹; 0) Q₁ᵀ. With it M x = b has the solution G b wherever
/// it has one, b − M G b is what no x explains (the algebraic equations among M y' = Ψ), and x − G M x what M doesn't see.
///
/// The rule for the rank: rows and columns are first scaled by powers of two, so that units don't matter; then a pivot counts
/// as zero if rounding of the entries alone explains it,
///
///     |R_kk| ≤ 8 n u |R_11|.                                                                                    (1)
///
/// A matrix that is nearly singular beyond that is regular.
#pragma once

#include <Eigen/Core>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// (1)
template <class T>
[[nodiscard]] T rank_threshold(Eigen::Index n) {
  return 8 * static_cast<T>(std::max<Eigen::Index>(n, 1)) * std::numeric_limits<T>::epsilon();
}

/// Powers of two that scale rows and columns of a matrix to a largest entry of about one; 1 for those that are zero.
template <class T>
struct Equilibrium {
  using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;
  Vector rows, columns;

  /// @param for_each  for_each(f) calls f(i, j, M_ij)
  Equilibrium(Eigen::Index n, auto&& for_each) : rows{Vector::Ones(n)}, columns{Vector::Ones(n)} {
    for (int pass = 0; pass < 3; ++pass) {
      scale(rows, for_each, [](Eigen::Index i, Eigen::Index) { return i; });
      scale(columns, for_each, [](Eigen::Index, Eigen::Index j) { return j; });
    }
  }

 private:
  void scale(Vector& by, auto& for_each, auto&& index) {
    Vector most = Vector::Zero(by.size());
    for_each([&](Eigen::Index i, Eigen::Index j, T m) {
      T& at = most[index(i, j)];
      at = std::max(at, std::abs(rows[i] * m * columns[j]));
    });
    for (Eigen::Index i = 0; i < by.size(); ++i)
      if (most[i] > 0) by[i] = std::ldexp(by[i], -std::ilogb(most[i]));
  }
};

/// Of a dense M.
template <class T>
class DenseGeneralizedInverse {
 public:
  using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;
  explicit DenseGeneralizedInverse(const Matrix& M)
      : scales_{M.rows(),
                [&M](auto&& f) {
                  for (Eigen::Index j = 0; j < M.cols(); ++j)
                    for (Eigen::Index i = 0; i < M.rows(); ++i)
                      if (M(i, j) != 0) f(i, j, M(i, j));
                }},
        qr_{M.rows(), M.cols()} {
    qr_.setThreshold(rank_threshold<T>(M.rows()));
    qr_.compute(scales_.rows.asDiagonal() * M * scales_.columns.asDiagonal());
  }
  [[nodiscard]] Eigen::Index rank() const { return qr_.rank(); }
  /// A component that M doesn't see but for others, −1 where M is regular.
  [[nodiscard]] Eigen::Index dependent() const {
    return rank() < qr_.cols() ? static_cast<Eigen::Index>(qr_.colsPermutation().indices()[rank()]) : -1;
  }
  /// x ← G x
  void solve(auto&& x) const {
    Eigen::Matrix<T, Eigen::Dynamic, 1> scaled = scales_.rows.cwiseProduct(x);
    x = scales_.columns.cwiseProduct(qr_.solve(scaled));
  }

 private:
  Equilibrium<T> scales_;
  Eigen::ColPivHouseholderQR<Matrix> qr_;
};

}  // namespace phistep::inline PHISTEP_ABI
