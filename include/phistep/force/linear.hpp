/// @file
/// Forces given as matrices. They are affine by construction: one factorization serves a whole run of constant Δt, and a
/// step is one linear solve.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// No dependence on the velocity.
struct NoMatrix {};

/// Ψ = K r + C v of a motion, or Ψ = K y of a first-order state, with K and C dense or sparse Eigen matrices over the
/// state's components in storage order. (A structure's stiffness matrix enters with its sign: K = −stiffness.)
template <class MatrixK, class MatrixC = NoMatrix>
struct LinearForce : ForceTerm {
  MatrixK K;                        ///< ∂Ψ/∂r [force/length], or ∂Ψ/∂y
  [[no_unique_address]] MatrixC C;  ///< ∂Ψ/∂v [force·time/length]

  static constexpr bool uses_velocity = !std::is_same_v<MatrixC, NoMatrix>, uses_time = false;
  static constexpr bool is_affine = true;
  static constexpr Structure structure =
      is_sparse_matrix<MatrixK> || is_sparse_matrix<MatrixC> ? Structure::sparse : Structure::dense;

  /// @throws std::invalid_argument unless the matrices are square and of one size
  explicit LinearForce(MatrixK position, MatrixC velocity = {}) : K(std::move(position)), C(std::move(velocity)) {
    check(K, K.rows());
    if constexpr (uses_velocity) check(C, K.rows());
  }

  void add(auto /*t*/, const auto& y, auto& out) const {
    if constexpr (requires { y.r; }) {
      add_product(K, y.r, out.force);
      if constexpr (uses_velocity) add_product(C, y.v, out.force);
    } else {
      static_assert(
          !uses_velocity || requires { y.r; }, "phistep: linear(K, C) needs a motion, with velocities");
      add_product(K, y.y, out.rate);
    }
  }
  void add_jacobian(auto /*t*/, const auto& y, auto& sink) const {
    for_each_stored(K, [&](Eigen::Index i, Eigen::Index j, auto x) {
      if constexpr (requires { y.r; }) sink.position(i, j, x);
      else sink.rate(i, j, x);
    });
    if constexpr (uses_velocity)
      for_each_stored(C, [&sink](Eigen::Index i, Eigen::Index j, auto x) { sink.velocity(i, j, x); });
  }
  /// −½ rᵀ K r [energy], C storing none
  [[nodiscard]] auto energy(auto /*t*/, const auto& y) const requires requires { y.r; }
  {
    using Scalar = typename std::remove_cvref_t<decltype(y.r)>::Scalar;
    const Scalar* const r = y.r.data();
    Scalar sum{0};
    for_each_stored(K, [&](Eigen::Index i, Eigen::Index j, auto x) { sum -= r[i] * static_cast<Scalar>(x) * r[j]; });
    return sum / 2;
  }
  /// Only where K is symmetric, to rounding, is its force that of a potential.
  [[nodiscard]] bool has_energy() const {
    using std::abs;
    using Entry = typename MatrixK::Scalar;
    Entry largest{0}, difference{0};
    for_each_stored(K, [&](Eigen::Index i, Eigen::Index j, Entry x) {
      largest = std::max(largest, abs(x));
      difference = std::max(difference, abs(x - K.coeff(j, i)));
    });
    return difference <= 16 * std::numeric_limits<Entry>::epsilon() * largest;
  }

 private:
  static void check(const auto& matrix, Eigen::Index n) {
    if (matrix.rows() != n || matrix.cols() != n)
      throw std::invalid_argument("phistep: linear(...) needs square matrices of one size, got " +
                                  std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()));
  }
  static void add_product(const auto& A, const auto& x, auto& out) {
    using Scalar = typename std::remove_cvref_t<decltype(out)>::Scalar;
    using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
    if (A.cols() != x.size())
      throw std::invalid_argument("phistep: linear(...) has " + std::to_string(A.cols()) + " columns, the state has " +
                                  std::to_string(x.size()) + " components");
    Eigen::Map<Column>(out.data(), out.size()).noalias() += A * Eigen::Map<const Column>(x.data(), x.size());
  }
};

/// The matrix that an expression makes: −S itself would refer to S, which may be gone before the force is called.
template <class Matrix>
using PlainMatrix = typename Matrix::PlainObject;

/// Ψ = K r, or K y; or K r + C v: matrices or expressions, `linear(-stiffness)`.
/// @throws std::invalid_argument unless they are square and of one size
template <class... Matrix>
[[nodiscard]] LinearForce<PlainMatrix<Matrix>...> linear(Matrix... K_and_C) {
  return LinearForce<PlainMatrix<Matrix>...>{PlainMatrix<Matrix>(std::move(K_and_C))...};
}

}}  // namespace phistep::PHISTEP_ABI
