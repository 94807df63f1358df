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

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// (1)
template <class T>
[[nodiscard]] T rank_threshold(Eigen::Index n) {
  return 8 * static_cast<T>(std::max<Eigen::Index>(n, 1)) * std::numeric_limits<T>::epsilon();
}

/// Powers of two that scale rows and columns of a matrix to largest entries of about one, 1 for those that are zero (D. Ruiz,
/// Rutherford Appleton Laboratory, report RAL-TR-2001-034): roots of the largest entries, both sides at once.
template <class T>
struct Equilibrium {
  using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;
  Vector rows, columns;
  Vector resolution;  ///< 1/rows; 0 for rows of zeros

  /// @param for_each  for_each(f) calls f(i, j, M_ij) for the entries that aren't zero
  Equilibrium(Eigen::Index n, auto&& for_each) : rows{Vector::Ones(n)}, columns{Vector::Ones(n)}, resolution(n) {
    Vector row(n), column(n);
    for (int pass = 0; pass < 12; ++pass) {
      row.setZero(), column.setZero();
      for_each([&](Eigen::Index i, Eigen::Index j, T m) {
        const T size = std::abs(rows[i] * m * columns[j]);
        row[i] = std::max(row[i], size);
        column[j] = std::max(column[j], size);
      });
      shrink(rows, row), shrink(columns, column);
    }
    for (Eigen::Index i = 0; i < n; ++i) resolution[i] = row[i] > 0 ? 1 / rows[i] : T{0};
  }

  /// What rounding leaves of b − M G b is nothing.
  void drop_rounding(auto&& left, const auto& b) const {
    T size{0};
    for (Eigen::Index i = 0; i < left.size(); ++i)
      if (resolution[i] > 0) size = std::max(size, std::abs(b[i]) * rows[i]);
    const T rounding = rank_threshold<T>(left.size()) * size;
    for (Eigen::Index i = 0; i < left.size(); ++i)
      if (std::abs(left[i]) <= rounding * resolution[i]) left[i] = 0;
  }

 private:
  static void shrink(Vector& by, const Vector& most) {
    for (Eigen::Index i = 0; i < by.size(); ++i)
      if (most[i] > 0) by[i] = std::ldexp(by[i], -static_cast<int>(std::lround(std::log2(most[i]) / 2)));
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
  [[nodiscard]] const Equilibrium<T>& scales() const { return scales_; }
  /// x ← G x
  void solve(auto&& x) const {
    Eigen::Matrix<T, Eigen::Dynamic, 1> scaled = scales_.rows.cwiseProduct(x);
    x = scales_.columns.cwiseProduct(qr_.solve(scaled));
  }

 private:
  Equilibrium<T> scales_;
  Eigen::ColPivHouseholderQR<Matrix> qr_;
};

}}  // namespace phistep::PHISTEP_ABI
