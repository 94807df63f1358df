/// @file
/// A sparse mass or capacity matrix, such as finite elements make.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <Eigen/SparseQR>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/step/mass/mass.hpp"
#include "phistep/step/mass/matrix_mass.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A sparse M, factorized once. Each solve allocates a vector, as Eigen's sparse solves do.
template <class T>
class SparseMass : public MatrixMass<SparseMass, Eigen::SparseMatrix<T>,
                                     Eigen::SparseQR<Eigen::SparseMatrix<T>, Eigen::COLAMDOrdering<int>>> {
 public:
  static constexpr Structure structure = Structure::sparse;
  using Matrix = Eigen::SparseMatrix<T>;
  using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;
  /// @throws std::invalid_argument unless the matrix is square and finite.
  explicit SparseMass(Matrix mass) : Base{std::move(mass)} {
    mass_.makeCompressed();
    if (mass_.rows() != mass_.cols() || !all_finite(mass_.valuePtr(), mass_.nonZeros()))
      throw std::invalid_argument("phistep: a mass matrix must be square and finite");
    auto lu = std::make_shared<Eigen::SparseLU<Matrix>>();
    lu->compute(mass_);
    const bool factorized = lu->info() == Eigen::Success;
    if (!factorized || is_doubtful(*lu)) {
      auto range = std::make_shared<typename Base::Range>(mass_);
      if (!factorized || range->rank() < mass_.rows()) range_ = std::move(range);
    }
    if (!range_) lu_ = std::move(lu);
  }
  /// x ← M⁻¹ x
  void solve(auto&& x) const {
    if (range_) range_->solve(x);
    else x = lu_->solve(x).eval();
  }
  [[nodiscard]] static bool has_cholesky_factor(const Matrix& M) {
    return Eigen::SimplicialLLT<Matrix>{M}.info() == Eigen::Success;
  }
  void subtract_product(const auto& x, auto&& out) const { out -= mass_ * x; }

 private:
  /// Factors of a singular M make a vector huge, but so do bad scales: then QR of the scaled M tells if M is singular.
  [[nodiscard]] bool is_doubtful(const Eigen::SparseLU<Matrix>& lu) const {
    if (mass_.rows() == 0) return false;
    Xorshift random{0x9e3779b97f4a7c15u};
    Vector x(mass_.rows());
    for (T& each : x) each = random.sign(T{1});
    T largest{0};
    for (Eigen::Index k = 0; k < mass_.nonZeros(); ++k) largest = std::max(largest, std::abs(mass_.valuePtr()[k]));
    x = lu.solve(x).eval();
    return !(x.cwiseAbs().maxCoeff() * largest < T(1e6));
  }

  using Base = typename SparseMass::MatrixMass;
  using Base::mass_, Base::range_;
  std::shared_ptr<Eigen::SparseLU<Matrix>> lu_;  // Eigen's SparseLU can't be copied or moved
};

template <class T, int options, class StorageIndex>
struct MassKind<Eigen::SparseMatrix<T, options, StorageIndex>> {
  using type = SparseMass<T>;
  static type make(const Eigen::SparseMatrix<T, options, StorageIndex>& m) { return type{Eigen::SparseMatrix<T>(m)}; }
};

}}  // namespace phistep::PHISTEP_ABI
