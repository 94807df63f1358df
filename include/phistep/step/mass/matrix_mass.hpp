/// @file
/// M as a matrix, factorized once. Where it is singular, G with M G M = M stands for M⁻¹ (generalized_inverse.hpp).
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/numbers/update.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/mass/generalized_inverse.hpp"
#include "phistep/step/matrix/dense_lu.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What mass matrices do by their solve(x): x ← M⁻¹ x, or G x.
/// @tparam Range  makes G
template <class Mass, class Matrix, class Range>
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
  [[nodiscard]] static UniformFactor<T> scaled(T h) { return {h}; }
  /// Symmetric but for rounding, and xᵀMx > 0 for all x ≠ 0.
  [[nodiscard]] bool is_positive_definite() const {
    const Matrix transposed = mass_.transpose();
    if ((mass_ - transposed).norm() > rank_threshold<T>(mass_.rows()) * mass_.norm()) return false;
    return Mass::has_cholesky_factor(mass_);
  }

 protected:
  explicit MatrixMass(Matrix mass) : mass_{std::move(mass)} {}
  void check_size(const auto& block) const {
    if (mass_.rows() != block.size())
      throw std::invalid_argument("phistep: a mass matrix of " + std::to_string(mass_.rows()) +
                                  " rows for a block of " + std::to_string(block.size()) + " components");
  }

  Matrix mass_;
  std::shared_ptr<const Range> range_;  // where M is singular

 private:
  [[nodiscard]] const Mass& self() const { return static_cast<const Mass&>(*this); }
};

/// A dense mass matrix, factorized once. It is singular where rounding of its entries explains a pivot (generalized_inverse.hpp).
template <class T>
class DenseMass
    : public MatrixMass<DenseMass<T>, Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>, DenseGeneralizedInverse<T>> {
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
    auto range = std::make_shared<DenseGeneralizedInverse<T>>(mass_);  // badly scaled, or singular
    if (range->rank() < mass_.rows() || !lu_.factorize()) range_ = std::move(range);
  }
  template <class Scalar, class Block>
  [[nodiscard]] DenseMass<Scalar> bind(const Block& block) const {
    this->check_size(block);
    return DenseMass<Scalar>{mass_.template cast<Scalar>()};
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
  void for_each_entry(Eigen::Index n, auto&& f) const {
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index i = 0; i < n; ++i) f(i, j, mass_(i, j));
  }
  void add_product(auto&& x, auto& out) const {
    for (Eigen::Index j = 0; j < mass_.cols(); ++j)
      for (Eigen::Index i = 0; i < mass_.rows(); ++i) out.data()[i] += mass_(i, j) * x(j);
  }

 private:
  using Base = typename DenseMass::MatrixMass;
  using Base::mass_, Base::range_;
  DenseLu<T, Eigen::Dynamic> lu_;
};

}}  // namespace phistep::PHISTEP_ABI
