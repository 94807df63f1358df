// What a small dense solver must do, for every size and scalar. Matrices and residuals are made in long double. The
// checks see a solver through an interface: they are compiled once, not for every size.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "support/catch.hpp"

namespace dense {

using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

/// A solver whose numbers are Scalars, seen in long double, which holds them exactly.
class Subject {
 public:
  virtual ~Subject() = default;
  virtual void set(const Matrix& A) = 0;
  [[nodiscard]] virtual Matrix matrix() = 0;  ///< after factorize() what that left there
  [[nodiscard]] virtual bool factorize() = 0;
  [[nodiscard]] virtual Vector solve(const Vector& b) = 0;
  /// Solves in rows [at, at + n) of a vector, in row `at` of a matrix.
  virtual void solve_in_segment(Vector& longer, int at) = 0;
  virtual void solve_in_row(Matrix& rows, int at) = 0;

  [[nodiscard]] virtual long double rounded(long double x) const = 0;
  [[nodiscard]] virtual long double epsilon() const = 0;
  [[nodiscard]] virtual long double smallest() const = 0;  ///< has no reciprocal
  [[nodiscard]] virtual int digits() const = 0;            ///< how far 10^±digits may scale rows
};
using Make = std::function<std::unique_ptr<Subject>()>;

template <class Scalar>
class Numbers : public Subject {
 public:
  using Dynamic = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using DynamicVector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Limits = std::numeric_limits<Scalar>;
  [[nodiscard]] long double rounded(long double x) const final { return static_cast<Scalar>(x); }
  [[nodiscard]] long double epsilon() const final { return Limits::epsilon(); }
  [[nodiscard]] long double smallest() const final { return Limits::denorm_min(); }
  [[nodiscard]] int digits() const final { return Limits::max_exponent10 > 100 ? 150 : 15; }
};

template <class Solver>
class SubjectOf final : public Numbers<typename Solver::Matrix::Scalar> {
  using Scalar = typename Solver::Matrix::Scalar;
  using Base = Numbers<Scalar>;

 public:
  explicit SubjectOf(int n) : n_{n} { solver_.resize(n); }
  void set(const Matrix& A) override {
    for (int j = 0; j < n_; ++j)
      for (int i = 0; i < n_; ++i) solver_.matrix()(i, j) = static_cast<Scalar>(A(i, j));
  }
  Matrix matrix() override {
    Matrix A(n_, n_);
    for (int j = 0; j < n_; ++j)
      for (int i = 0; i < n_; ++i) A(i, j) = solver_.matrix()(i, j);
    return A;
  }
  bool factorize() override { return solver_.factorize(); }
  Vector solve(const Vector& b) override {
    Eigen::Matrix<Scalar, Solver::Matrix::RowsAtCompileTime, 1> x(n_);
    for (int i = 0; i < n_; ++i) x[i] = static_cast<Scalar>(b[i]);
    solver_.solve_in_place(x);
    Vector y(n_);
    for (int i = 0; i < n_; ++i) y[i] = x[i];
    return y;
  }
  void solve_in_segment(Vector& longer, int at) override {
    typename Base::DynamicVector x(longer.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = static_cast<Scalar>(longer[i]);
    solver_.solve_in_place(x.segment(at, n_));
    for (Eigen::Index i = 0; i < x.size(); ++i) longer[i] = x[i];
  }
  void solve_in_row(Matrix& rows, int at) override {
    typename Base::Dynamic x(rows.rows(), rows.cols());
    for (Eigen::Index k = 0; k < x.size(); ++k) x.data()[k] = static_cast<Scalar>(rows.data()[k]);
    solver_.solve_in_place(x.row(at));
    for (Eigen::Index k = 0; k < x.size(); ++k) rows.data()[k] = x.data()[k];
  }

  [[nodiscard]] Solver& solver() { return solver_; }

 private:
  int n_;
  Solver solver_;
};
template <class Solver>
[[nodiscard]] Make subject(int n) {
  return [n] { return std::make_unique<SubjectOf<Solver>>(n); };
}

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
  if (kind == "nearly singular" && n > 1)
    for (int j = 0; j < n; ++j) A(n - 1, j) = A(0, j) + small * A(n - 1, j);
  return A;
}
inline Matrix identity(int n) {
  Matrix A = Matrix::Zero(n, n);
  for (int i = 0; i < n; ++i) A(i, i) = 1;
  return A;
}
inline Vector absolute(Vector x) {
  for (long double& each : x) each = std::abs(each);
  return x;
}
inline Matrix absolute(Matrix A) {
  for (Eigen::Index k = 0; k < A.size(); ++k) A.data()[k] = std::abs(A.data()[k]);
  return A;
}
// By loops: Eigen's products of long doubles take a second to compile.
inline Vector times(const Matrix& A, const Vector& x) {
  Vector y = Vector::Zero(A.rows());
  for (Eigen::Index j = 0; j < A.cols(); ++j)
    for (Eigen::Index i = 0; i < A.rows(); ++i) y[i] += A(i, j) * x[j];
  return y;
}
inline Matrix times(const Matrix& A, const Matrix& B) {
  Matrix C = Matrix::Zero(A.rows(), B.cols());
  for (Eigen::Index j = 0; j < B.cols(); ++j)
    for (Eigen::Index k = 0; k < A.cols(); ++k)
      for (Eigen::Index i = 0; i < A.rows(); ++i) C(i, j) += A(i, k) * B(k, j);
  return C;
}

/// check(n, make) for these sizes. Every n is a compilation of its own.
template <template <int> class SolverOf>
void for_sizes(const std::function<void(int, const Make&)>& check, auto sizes) {
  [&]<int... n>(std::integer_sequence<int, n...>) { (check(n, subject<SolverOf<n>>(n)), ...); }
  (sizes);
}

/// |L||U| of PA = LU with row pivoting, and where P takes the rows.
struct Elimination {
  explicit Elimination(Matrix A) {
    const Eigen::Index n = A.rows();
    std::vector<Eigen::Index> from(static_cast<std::size_t>(n));  // whose row is where
    for (Eigen::Index i = 0; i < n; ++i) from[static_cast<std::size_t>(i)] = i;
    for (Eigen::Index k = 0; k < n; ++k) {
      Eigen::Index pivot = k;
      for (Eigen::Index i = k + 1; i < n; ++i)
        if (std::abs(A(i, k)) > std::abs(A(pivot, k))) pivot = i;
      for (Eigen::Index j = 0; j < n; ++j) std::swap(A(k, j), A(pivot, j));
      std::swap(from[static_cast<std::size_t>(k)], from[static_cast<std::size_t>(pivot)]);
      for (Eigen::Index i = k + 1; i < n; ++i) {
        A(i, k) /= A(k, k);
        for (Eigen::Index j = k + 1; j < n; ++j) A(i, j) -= A(i, k) * A(k, j);
      }
    }
    Matrix L = identity(static_cast<int>(n)), U = Matrix::Zero(n, n);
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index i = 0; i < n; ++i) (i > j ? L : U)(i, j) = A(i, j);
    const Matrix sorted = times(absolute(L), absolute(U));
    product.resize(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) product(from[static_cast<std::size_t>(i)], j) = sorted(i, j);
  }
  Matrix product;
};

/// The vector that |A x − b| ≤ 8 n u · bound is held to, row by row. It contains the growth of the elimination, as bounds
/// with ‖A‖ alone would not: where rows are scaled badly, the pivot of a row may be forced upon it, and be small.
using Bound = std::function<Vector(const Matrix& A, Subject& solver, const Vector& b, const Vector& x)>;

/// Solves with all kinds of matrices.
inline void solves(int n, const Make& make, const Bound& bound, bool scaled = true) {
  for (const std::string kind : kinds) {
    if (!scaled && kind == "rows scaled") continue;
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const auto solver = make();
      const int digits = solver->digits();
      const long double u = solver->epsilon() / 2;
      CAPTURE(n, kind, seed, digits);
      solver->set(matrix(kind, n, seed, digits, 64 * std::sqrt(u)));
      const Matrix A = solver->matrix();
      Vector b = Vector::Random(n);
      for (int i = 0; i < n; ++i) {
        long double largest = 0;  // neither over- nor underflow
        for (int j = 0; j < n; ++j) largest = std::max(largest, std::abs(A(i, j)));
        b[i] = solver->rounded(b[i] * largest);
      }
      REQUIRE(solver->factorize());
      const Vector y = solver->solve(b), product = times(A, y), allowed = bound(A, *solver, b, y);
      bool good = true;
      for (int i = 0; i < n; ++i) good = good && std::abs(product[i] - b[i]) <= 8 * n * u * allowed[i];
      CHECK(good);
    }
  }
}

inline void refuses_singular(int n, const Make& make) {
  CAPTURE(n);
  const auto solver = make();
  solver->set(Matrix::Zero(n, n));
  CHECK_FALSE(solver->factorize());
  for (const long double all : {1.0L, -3.0L}) {
    solver->set(Matrix::Constant(n, n, all));
    CHECK(solver->factorize() == (n == 1));
  }
  for (int k = 0; k < n; ++k) {
    Matrix A = identity(n);
    A(k, k) = 0;
    solver->set(A);
    CHECK_FALSE(solver->factorize());
    A(k, k) = solver->smallest();
    solver->set(A);
    CHECK_FALSE(solver->factorize());
  }
  solver->set(identity(n));
  CHECK(solver->factorize());  // nothing is left of the failures
}

/// An infinity off the diagonal may leave all pivots finite; the solution then gives it away.
inline void refuses_non_finite(int n, const Make& make) {
  using Limits = std::numeric_limits<long double>;
  for (const long double bad : {Limits::quiet_NaN(), -Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()})
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const auto solver = make();
        Matrix A = Matrix::Constant(n, n, 1);
        for (int k = 0; k < n; ++k) A(k, k) = 4;
        A(i, j) = bad;
        solver->set(A);
        const bool accepted = solver->factorize();
        Vector x = Vector::Constant(n, 1);
        if (accepted) x = solver->solve(x);
        bool finite = true;
        for (const long double each : x) finite = finite && std::isfinite(each);
        CAPTURE(n, i, j, bad);
        CHECK_FALSE((accepted && finite));
      }
}

/// The right-hand side may lie anywhere: part of a vector, every second number, a row.
inline void solves_where_x_lies(int n, const Make& make) {
  const auto solver = make();
  solver->set(matrix("permuted", n, 7, 0, 0));
  REQUIRE(solver->factorize());
  Vector b = Vector::Random(n);
  for (long double& each : b) each = solver->rounded(each);
  const Vector expected = solver->solve(b);

  Vector longer = Vector::Constant(n + 2, 42);
  for (int i = 0; i < n; ++i) longer[1 + i] = b[i];
  solver->solve_in_segment(longer, 1);
  bool same = true;
  for (int i = 0; i < n; ++i) same = same && longer[1 + i] == expected[i];
  CHECK(same);
  CHECK((longer[0] == 42 && longer[n + 1] == 42));

  Matrix rows = Matrix::Constant(3, n, 42);
  for (int i = 0; i < n; ++i) rows(1, i) = b[i];
  solver->solve_in_row(rows, 1);
  same = true;
  bool untouched = true;
  for (int i = 0; i < n; ++i) {
    same = same && rows(1, i) == expected[i];
    untouched = untouched && rows(0, i) == 42 && rows(2, i) == 42;
  }
  CHECK(same);
  CHECK(untouched);
}

}  // namespace dense
