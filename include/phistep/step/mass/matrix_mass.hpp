/// @file
/// M as a matrix, factorized once. Where it is singular, G with M G M = M stands for M⁻¹.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/numbers/update.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/step/matrix/dense_lu.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// G with M G M = M for a singular M, by a QR decomposition with column pivoting (Golub & Van Loan, Matrix Computations,
// 4th ed., sect. 5.4.2 and 5.5.7): M P = Q (R₁ R₂; 0 0), G = P (R₁⁻¹; 0) Q₁ᵀ. With it M x = b has the solution G b wherever
// it has one, b − M G b is what no x explains (the algebraic equations among M y' = Ψ), and x − G M x what M doesn't see.
//
// The rule for the rank: rows and columns are first scaled by powers of two, so that units don't matter; then a pivot counts
// as zero if rounding of the entries alone explains it,
//
//     |R_kk| ≤ 8 n u |R_11|.                                                                                    (1)
//
// A matrix that is nearly singular beyond that is regular.

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

/// G of a dense or sparse M, by the QR decomposition that Eigen has for its kind.
template <class Matrix, class Qr>
class GeneralizedInverse {
  using T = typename Matrix::Scalar;
  using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;

 public:
  explicit GeneralizedInverse(const Matrix& M)
      : scales_{M.rows(), [&M](auto&& f) {
                  for_each_stored(M, [&f](Eigen::Index i, Eigen::Index j, T m) {
                    if (m != 0) f(i, j, m);
                  });
                }} {
    Matrix scaled = scales_.rows.asDiagonal() * M * scales_.columns.asDiagonal();
    const T threshold = rank_threshold<T>(M.rows());
    if constexpr (is_sparse_matrix<Matrix>) {
      scaled.makeCompressed();
      qr_.setPivotThreshold(threshold);  // columns are about as long as one
    } else {
      qr_.setThreshold(threshold);
    }
    qr_.compute(scaled);
  }
  [[nodiscard]] Eigen::Index rank() const { return qr_.rank(); }
  /// A component that M doesn't see but for others, −1 where M is regular.
  [[nodiscard]] Eigen::Index dependent() const {
    return rank() < qr_.cols() ? static_cast<Eigen::Index>(qr_.colsPermutation().indices()[rank()]) : -1;
  }
  [[nodiscard]] const Equilibrium<T>& scales() const { return scales_; }
  /// x ← G x
  void solve(auto&& x) const {
    const Vector scaled = scales_.rows.cwiseProduct(x), found = qr_.solve(scaled);
    x = scales_.columns.cwiseProduct(found);
  }

 private:
  Equilibrium<T> scales_;
  Qr qr_;
};

/// What mass matrices do by their solve(x): x ← M⁻¹ x, or G x.
template <template <class> class Mass, class Matrix, class Qr>
class MatrixMass {
  using T = typename Matrix::Scalar;
  using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;

 public:
  static constexpr bool is_matrix = true;
  [[nodiscard]] Eigen::Index algebraic() const { return range_ ? range_->dependent() : -1; }
  void keep_unexplained(auto&& x) const {
    const Vector b = x;
    Vector explained = b;
    self().solve(explained);
    x -= mass_ * explained;
    if (range_) range_->scales().drop_rounding(x, b);
    else x.setZero();
  }
  void keep_unseen(auto&& x) const {
    Vector seen = mass_ * x;
    self().solve(seen);
    x -= seen;
  }
  [[nodiscard]] static UniformFactor<T> h_over_mass(T h) { return {h}; }
  void for_each_entry(Eigen::Index /*n*/, auto&& f) const { for_each_stored(mass_, f); }
  void add_product(auto&& x, auto& out) const {
    for_each_stored(mass_, [&](Eigen::Index i, Eigen::Index j, T m) { out.data()[i] += m * x(j); });
  }
  /// Symmetric but for rounding, and xᵀMx > 0 for all x ≠ 0.
  [[nodiscard]] bool is_positive_definite() const {
    const Matrix transposed = mass_.transpose();
    if ((mass_ - transposed).norm() > rank_threshold<T>(mass_.rows()) * mass_.norm()) return false;
    return Mass<T>::has_cholesky_factor(mass_);
  }
  /// @throws std::invalid_argument where the block has another size
  template <class Scalar>
  [[nodiscard]] Mass<Scalar> bind(const auto& block) const {
    if (mass_.rows() != block.size())
      throw std::invalid_argument("phistep: a mass matrix of " + std::to_string(mass_.rows()) +
                                  " rows for a block of " + std::to_string(block.size()) + " components");
    return Mass<Scalar>{typename Mass<Scalar>::Matrix(mass_.template cast<Scalar>())};
  }

 protected:
  using Range = GeneralizedInverse<Matrix, Qr>;
  explicit MatrixMass(Matrix mass) : mass_{std::move(mass)} {}

  Matrix mass_;
  std::shared_ptr<const Range> range_;  // where M is singular

 private:
  [[nodiscard]] const Mass<T>& self() const { return static_cast<const Mass<T>&>(*this); }
};

/// A dense mass matrix, factorized once. It is singular where rounding of its entries explains a pivot.
template <class T>
class DenseMass : public MatrixMass<DenseMass, Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>,
                                    Eigen::ColPivHouseholderQR<Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>>> {
 public:
  static constexpr Structure structure = Structure::dense;
  using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;
  /// @throws std::invalid_argument unless the matrix is square and finite.
  explicit DenseMass(Matrix mass) : Base{std::move(mass)} {
    if (mass_.rows() != mass_.cols()) throw std::invalid_argument("phistep: a mass matrix must be square");
    if (!mass_.allFinite()) throw std::invalid_argument("phistep: a mass matrix must be finite");
    lu_.resize(mass_.rows());
    lu_.matrix() = mass_;
    if (lu_.factorize() && lu_.pivot_ratio() > T(1e-6)) return;
    auto range = std::make_shared<typename Base::Range>(mass_);  // badly scaled, or singular
    if (range->rank() < mass_.rows() || !lu_.factorize()) range_ = std::move(range);
  }
  /// x ← M⁻¹ x
  void solve(auto&& x) const {
    if (range_) range_->solve(x);
    else lu_.solve_in_place(x);
  }
  [[nodiscard]] static bool has_cholesky_factor(const Matrix& M) {
    return Eigen::LLT<Matrix>{M}.info() == Eigen::Success;
  }
  void subtract_product(const auto& x, auto&& out) const { out.noalias() -= mass_ * x; }

 private:
  using Base = typename DenseMass::MatrixMass;
  using Base::mass_, Base::range_;
  DenseLu<T, Eigen::Dynamic> lu_;
};

}}  // namespace phistep::PHISTEP_ABI
