/// @file
/// A sparse mass or capacity matrix, such as finite elements make.
#pragma once

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/linear/mass.hpp"
#include "phistep/simd/update.hpp"

namespace phistep::inline PHISTEP_ABI {

/// A sparse M, factorized once. Eigen's sparse solve allocates a vector a call.
template <class T>
class SparseMass {
 public:
  static constexpr bool is_matrix = true;
  static constexpr Structure structure = Structure::sparse;
  using Matrix = Eigen::SparseMatrix<T>;
  /// @throws std::invalid_argument unless the matrix is square, finite and invertible.
  explicit SparseMass(Matrix mass) : mass_{std::move(mass)}, lu_{std::make_shared<Eigen::SparseLU<Matrix>>()} {
    mass_.makeCompressed();
    const bool usable = mass_.rows() == mass_.cols() && all_finite(mass_.valuePtr(), mass_.nonZeros());
    if (usable) lu_->compute(mass_);
    if (!usable || lu_->info() != Eigen::Success)
      throw std::invalid_argument("phistep: a mass matrix must be square, finite and invertible");
  }
  template <class Scalar, class Block>
  [[nodiscard]] SparseMass<Scalar> bind(const Block& block) const {
    if (mass_.rows() != block.size())
      throw std::invalid_argument("phistep: a mass matrix of " + std::to_string(mass_.rows()) +
                                  " rows for a block of " + std::to_string(block.size()) + " components");
    return SparseMass<Scalar>{Eigen::SparseMatrix<Scalar>(mass_.template cast<Scalar>())};
  }
  /// x ← M⁻¹ x
  void solve(auto&& x) const { x = lu_->solve(x).eval(); }
  [[nodiscard]] static UniformFactor<T> scaled(T h) { return {h}; }
  void subtract_product(const auto& x, auto&& out) const { out -= mass_ * x; }
  void for_each_entry(Eigen::Index, auto&& f) const {
    for (Eigen::Index outer = 0; outer < mass_.outerSize(); ++outer)
      for (typename Matrix::InnerIterator entry(mass_, outer); entry; ++entry)
        f(entry.row(), entry.col(), entry.value());
  }
  void add_product(auto&& x, auto& out) const {
    for_each_entry(0, [&](Eigen::Index i, Eigen::Index j, T m) { out.data()[i] += m * x(j); });
  }

 private:
  Matrix mass_;
  std::shared_ptr<Eigen::SparseLU<Matrix>> lu_;  // Eigen's SparseLU can't be copied or moved
};

template <class T, int options, class StorageIndex>
struct MassKind<Eigen::SparseMatrix<T, options, StorageIndex>> {
  using type = SparseMass<T>;
  static type make(const Eigen::SparseMatrix<T, options, StorageIndex>& m) { return type{Eigen::SparseMatrix<T>(m)}; }
};

}  // namespace phistep::inline PHISTEP_ABI
