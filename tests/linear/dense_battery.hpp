// What a small dense solver must do, for every size and scalar. Matrices and residuals are made in long double.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>

#include "support/catch.hpp"

namespace dense {

using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

inline constexpr std::array kinds{"random",         "permuted",    "graded rows",
                                  "graded columns", "rows scaled", "nearly singular"};

/// @param digits  how far 10^±digits may scale rows
/// @param small   how near to singular
inline Matrix matrix(const std::string& kind, int n, unsigned seed, int digits, long double small) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Matrix A(n, n);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) A(i, j) = uniform(random);
  if (n == 1) A(0, 0) += 2;
  if (kind == "permuted") {  // no pivot is where it is looked for: rows shifted by one of a dominant diagonal
    A.diagonal().array() += 2 * n;
    const Matrix top = A.row(0);
    for (int i = 0; i + 1 < n; ++i) A.row(i) = A.row(i + 1).eval();
    A.row(n - 1) = top;
  }
  for (int i = 0; i < n; ++i) {
    if (kind == "graded rows") A.row(i) *= std::pow(10.0L, -static_cast<long double>(i));
    if (kind == "graded columns") A.col(i) *= std::pow(10.0L, -static_cast<long double>(i));
    if (kind == "rows scaled") A.row(i) *= std::pow(10.0L, i % 2 == 0 ? digits : -digits);
  }
  if (kind == "nearly singular" && n > 1) A.row(n - 1) = A.row(0) + small * A.row(n - 1);
  return A;
}

template <int... n>
void for_sizes(auto check, std::integer_sequence<int, n...>) {
  (check(std::integral_constant<int, n>{}), ...);
}
/// check(n) for the sizes at which something changes: rows held in registers (1 … 3), packets full, short by one, over by
/// one. Every n is a compilation of its own; the scalar that is used most gets the most.
template <class Scalar>
void for_each_size(auto check) {
  if constexpr (std::is_same_v<Scalar, double>)
    for_sizes(check, std::integer_sequence<int, 1, 2, 3, 4, 5, 7, 8, 9, 12, 20, 32>{});
  else for_sizes(check, std::integer_sequence<int, 1, 2, 3, 4, 9>{});
}

/// |L||U| of PA = LU with row pivoting, and where P takes the rows; and |L||U||U⁻¹||U|.
struct Elimination {
  explicit Elimination(const Matrix& A) : lu(A) {
    const Matrix L = lu.matrixLU().triangularView<Eigen::UnitLower>(), U = lu.matrixLU().triangularView<Eigen::Upper>();
    const Matrix inverse = U.triangularView<Eigen::Upper>().solve(Matrix::Identity(U.rows(), U.rows()));
    product = lu.permutationP().transpose() * (L.cwiseAbs() * U.cwiseAbs());
    gauss_jordan = product * (inverse.cwiseAbs() * U.cwiseAbs());
  }
  Eigen::PartialPivLU<Matrix> lu;
  Matrix product, gauss_jordan;
};

/// Solves with all kinds of matrices. `bound(A, solver, b, x)` is the vector that |A x − b| ≤ 8 n u · bound is held to, row
/// by row. It contains the growth of the elimination, as bounds with ‖A‖ alone would not: where rows are scaled badly, the
/// pivot of a row may be forced upon it, and be small.
template <class Solver, class Bound>
void solves(int n, Bound bound, bool scaled = true) {
  using Scalar = typename Solver::Matrix::Scalar;
  const int digits = std::numeric_limits<Scalar>::max_exponent10 > 100 ? 150 : 15;
  const long double u = std::numeric_limits<Scalar>::epsilon() / Scalar{2};
  for (const std::string kind : kinds) {
    if (!scaled && kind == "rows scaled") continue;
    for (unsigned seed = 1; seed <= 5; ++seed) {
      CAPTURE(n, kind, seed, digits);
      Solver solver;
      solver.resize(n);
      solver.matrix() = matrix(kind, n, seed, digits, 64 * std::sqrt(u)).template cast<Scalar>();
      const Matrix A = solver.matrix().template cast<long double>();
      Eigen::Matrix<Scalar, Solver::Matrix::RowsAtCompileTime, 1> x(n);
      x.setRandom();
      for (int i = 0; i < n; ++i) x[i] *= solver.matrix().row(i).cwiseAbs().maxCoeff();  // neither over- nor underflow
      const Vector b = x.template cast<long double>();
      REQUIRE(solver.factorize());
      solver.solve_in_place(x);
      const Vector y = x.template cast<long double>();
      const Vector residual = (A * y - b).cwiseAbs(), allowed = 8 * n * u * bound(A, solver, b, y);
      CHECK((residual.array() <= allowed.array()).all());
    }
  }
}

template <class Solver>
void refuses_singular(int n) {
  using Scalar = typename Solver::Matrix::Scalar;
  CAPTURE(n);
  Solver solver;
  solver.resize(n);
  solver.matrix().setZero(n, n);
  CHECK_FALSE(solver.factorize());
  for (const Scalar all : {Scalar{1}, Scalar{-3}}) {
    solver.matrix().setConstant(n, n, all);
    CHECK(solver.factorize() == (n == 1));
  }
  for (int k = 0; k < n; ++k) {
    solver.matrix().setIdentity(n, n);
    solver.matrix()(k, k) = 0;
    CHECK_FALSE(solver.factorize());
    solver.matrix()(k, k) = std::numeric_limits<Scalar>::denorm_min();  // has no reciprocal
    CHECK_FALSE(solver.factorize());
  }
  solver.matrix().setIdentity(n, n);
  CHECK(solver.factorize());  // nothing is left of the failures
}

/// An infinity off the diagonal may leave all pivots finite; the solution then gives it away.
template <class Solver>
void refuses_non_finite(int n) {
  using Scalar = typename Solver::Matrix::Scalar;
  using Limits = std::numeric_limits<Scalar>;
  for (const Scalar bad : {Limits::quiet_NaN(), -Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()})
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        Solver solver;
        solver.resize(n);
        solver.matrix().setIdentity(n, n);
        solver.matrix().diagonal() *= 3;
        solver.matrix().array() += Scalar{1};
        solver.matrix()(i, j) = bad;
        Eigen::Matrix<Scalar, Solver::Matrix::RowsAtCompileTime, 1> x(n);
        x.setOnes();
        const bool accepted = solver.factorize();
        if (accepted) solver.solve_in_place(x);
        CAPTURE(n, i, j, bad);
        CHECK_FALSE((accepted && x.allFinite()));
      }
}

/// The right-hand side may lie anywhere: part of a vector, every second number, a row.
template <class Solver>
void solves_where_x_lies(int n) {
  using Scalar = typename Solver::Matrix::Scalar;
  Solver solver;
  solver.resize(n);
  solver.matrix() = matrix("permuted", n, 7, 0, 0).template cast<Scalar>();
  REQUIRE(solver.factorize());
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> expected = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>::Random(n), b = expected;
  solver.solve_in_place(expected);

  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> longer = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>::Constant(n + 2, 42);
  longer.segment(1, n) = b;
  solver.solve_in_place(longer.segment(1, n));
  CHECK(longer.segment(1, n) == expected);
  CHECK((longer[0] == 42 && longer[n + 1] == 42));

  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> rows =
      Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>::Constant(3, n, 42);
  rows.row(1) = b.transpose();
  solver.solve_in_place(rows.row(1));
  CHECK(rows.row(1).transpose() == expected);
  CHECK(((rows.row(0).array() == 42).all() && (rows.row(2).array() == 42).all()));
}

}  // namespace dense
