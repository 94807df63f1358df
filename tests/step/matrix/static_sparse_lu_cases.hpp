// What static_sparse_lu.test.cpp and static_sparse_lu.full.cpp share.
#pragma once

#include <phistep/step/matrix/static_sparse_lu.hpp>

#include <random>

#include "step/matrix/dense_battery.hpp"

using namespace phistep;

namespace static_sparse_lu_cases {

/// The solver in the battery's clothes.
template <class Scalar, int n, class Pattern>
class Solver {
 public:
  using Lu = StaticSparseLu<Scalar, n, Pattern>;
  using Matrix = Eigen::Matrix<Scalar, n, n>;
  static void resize(int) {}
  Matrix& matrix() { return a_; }
  bool factorize() {
    return lu_.factorize([this](auto& values) {
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          if (const int slot = Lu::plan(i, j); slot >= 0) values[static_cast<std::size_t>(slot)] = a_(i, j);
    });
  }
  void solve_in_place(auto&& x) const { lu_.solve_in_place(x); }
  bool is_dense() const { return lu_.is_dense(); }

 private:
  Matrix a_ = Matrix::Zero();
  Lu lu_;
};

template <int n>
struct Full {
  static constexpr auto pattern = [] {
    std::array<MatrixEntry, n * n> all;
    for (int i = 0; i < n * n; ++i) all[static_cast<std::size_t>(i)] = {i / n, i % n};
    return all;
  }();
};
/// Row 0 and column 0 and the diagonal: eliminated in the order given, it would fill up.
template <int n>
struct Arrow {
  static constexpr auto pattern = [] {
    std::array<MatrixEntry, 2 * n> all{};
    for (int i = 1; i < n; ++i)
      all[2 * static_cast<std::size_t>(i)] = {0, i}, all[2 * static_cast<std::size_t>(i) + 1] = {i, 0};
    return all;
  }();
};
/// A chain of reactions with two returns.
struct Chain {
  static constexpr int n = 20;
  static constexpr auto pattern = [] {
    std::array<MatrixEntry, n + 1> all{};
    for (int i = 1; i < n; ++i) all[static_cast<std::size_t>(i)] = {i, i - 1};
    all[0] = {3, 17};
    all[n] = {0, 11};
    return all;
  }();
};

// As DenseLu, whose test cites it; with multipliers up to 8 in place of 1, |L||U| is that of the elimination done, which
// for these well-conditioned matrices stays below 8 times that of row pivoting.
inline dense::Vector of_elimination(const dense::Matrix& A, dense::Subject&, const dense::Vector&,
                                    const dense::Vector& x) {
  return 8 * dense::times(dense::Elimination(A).product, dense::absolute(x));
}

template <class Scalar>
struct Static {
  template <int n>
  using OfSize = Solver<Scalar, n, Full<n>>;
};
template <class Scalar>
using Sizes = std::conditional_t<std::is_same_v<Scalar, double>, std::integer_sequence<int, 1, 2, 6>,
                                 std::integer_sequence<int, 3>>;
inline void solves_well(int n, const dense::Make& make) { dense::solves(n, make, of_elimination); }
inline void refuses(int n, const dense::Make& make) {
  dense::refuses_singular(n, make);
  dense::refuses_non_finite(n, make);
}

/// |A x − b| ≤ 8 n u |L||U||x|, as above.
inline bool solves(dense::Subject& solver, int n) {
  dense::Vector b(n);
  for (int i = 0; i < n; ++i) b[i] = solver.rounded(-1 + 3.0L * i / (n - 1));
  const dense::Matrix A = solver.matrix();
  if (!solver.factorize()) return false;
  const dense::Vector y = solver.solve(b), product = dense::times(A, y), allowed = of_elimination(A, solver, b, y);
  bool good = true;
  for (int i = 0; i < n; ++i) good = good && std::abs(product[i] - b[i]) <= 8 * n * 1.1e-16L * allowed[i];
  return good;
}

}  // namespace static_sparse_lu_cases
