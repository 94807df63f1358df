#include <phistep/step/matrix/static_sparse_system.hpp>

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
  static constexpr auto jacobian_pattern = [] {
    std::array<MatrixEntry, n * n> all;
    for (int i = 0; i < n * n; ++i) all[static_cast<std::size_t>(i)] = {i / n, i % n};
    return all;
  }();
};
/// Row 0 and column 0 and the diagonal: eliminated in the order given, it would fill up.
template <int n>
struct Arrow {
  static constexpr auto jacobian_pattern = [] {
    std::array<MatrixEntry, 2 * n> all{};
    for (int i = 1; i < n; ++i)
      all[2 * static_cast<std::size_t>(i)] = {0, i}, all[2 * static_cast<std::size_t>(i) + 1] = {i, 0};
    return all;
  }();
};
/// A chain of reactions with two returns.
struct Chain {
  static constexpr int n = 20;
  static constexpr auto jacobian_pattern = [] {
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
using StaticSizes = std::conditional_t<std::is_same_v<Scalar, double>, std::integer_sequence<int, 1, 2, 6>,
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

using namespace static_sparse_lu_cases;

#if PHISTEP_QUICK

TEMPLATE_TEST_CASE("any matrix is solved as well as by dense LU", "", double) {
  dense::for_sizes<Static<TestType>::template OfSize>(solves_well, std::integer_sequence<int, 3>{});
}

TEMPLATE_TEST_CASE("a singular matrix or a bad entry is refused", "", double) {
  dense::for_sizes<Static<TestType>::template OfSize>(refuses, std::integer_sequence<int, 3>{});
}

TEMPLATE_TEST_CASE("it solves in place", "", double) {
  dense::for_sizes<Static<TestType>::template OfSize>(dense::solves_where_x_lies, std::integer_sequence<int, 3>{});
}

TEST_CASE("the order of pivots makes no fill where none is needed") {
  constexpr int n = 12;
  constexpr EliminationPlan<n> arrow{Arrow<n>::jacobian_pattern};
  STATIC_REQUIRE(arrow.slots == 3 * n - 2);
  STATIC_REQUIRE(arrow.products == n - 1);
  STATIC_REQUIRE(arrow(1, 2) == EliminationPlan<n>::none);
  constexpr EliminationPlan<5> full{Full<5>::jacobian_pattern};
  STATIC_REQUIRE(full.slots == 25);
  STATIC_REQUIRE(full.products == 16 + 9 + 4 + 1);
  // The diagonal is there without being named, and comes first.
  for (int i = 0; i < n; ++i) CHECK(arrow(i, i) == i);
}

TEST_CASE("a Jacobian's own code gives its pattern, each entry once") {
  constexpr auto pattern = pattern_of<4>([](const auto& y, auto&& put) {
    put(0, 1, y[0] - y[1]);  // zero at a y of ones: there all the same
    put(3, 2, 2.0), put(0, 1, 3 * y[3]), put(2, 2, 1);
  });
  STATIC_REQUIRE(pattern.size() == 3);
  constexpr EliminationPlan<4> plan{pattern};
  STATIC_REQUIRE(plan.slots == 4 + 2);
  STATIC_REQUIRE(plan(0, 1) >= 4);
  STATIC_REQUIRE(plan(3, 2) >= 4);
  STATIC_REQUIRE(plan(1, 0) == EliminationPlan<4>::none);
}

TEST_CASE("sparse matrices: no zero is looked at, and the residual is rounding") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int run = 0; run < 20; ++run) {
    dense::SubjectOf<Solver<double, Chain::n, Chain>> chain(Chain::n);
    dense::SubjectOf<Solver<double, 12, Arrow<12>>> arrow(12);
    // Columns whose diagonal outweighs them, as I − γJ of conserved species has: no multiplier exceeds 1.
    const auto fill = [&](auto& A, const auto& pattern) {
      A.setIdentity();
      for (const MatrixEntry& e : pattern) {
        const double rate = std::pow(10, 12 * uniform(random) - 6);
        if (e.row == e.column) continue;
        A(e.row, e.column) -= rate;
        A(e.column, e.column) += rate;
      }
    };
    fill(chain.solver().matrix(), Chain::jacobian_pattern);
    fill(arrow.solver().matrix(), Arrow<12>::jacobian_pattern);
    CHECK(solves(chain, Chain::n));
    CHECK_FALSE(chain.solver().is_dense());
    CHECK(solves(arrow, 12));
    CHECK_FALSE(arrow.solver().is_dense());
  }
}

TEST_CASE("where the diagonal offers no pivot, rows are exchanged") {
  dense::SubjectOf<Solver<double, Chain::n, Chain>> chain(Chain::n);
  auto& A = chain.solver().matrix();
  A.setIdentity();
  for (const MatrixEntry& e : Chain::jacobian_pattern) A(e.row, e.column) = 0.5 + 0.01 * e.row;
  REQUIRE(solves(chain, Chain::n));
  CHECK_FALSE(chain.solver().is_dense());
  // The smallest multiplier that is trusted no more is 8.
  for (const auto& [diagonal, dense] : {std::pair{0.1, false}, {0.05, true}, {1e-18, true}, {0.0, true}}) {
    CAPTURE(diagonal);
    A(4, 4) = diagonal;  // below it: 0.55
    CHECK(solves(chain, Chain::n));
    CHECK(chain.solver().is_dense() == dense);
  }
  A(4, 4) = 1;
  CHECK(solves(chain, Chain::n));  // nothing is left of it
  CHECK_FALSE(chain.solver().is_dense());
  A.row(7).setZero();
  CHECK_FALSE(chain.factorize());
}

#elif PHISTEP_FULL

TEMPLATE_TEST_CASE("any matrix is solved as well as by dense LU", "", float, double, long double) {
  dense::for_sizes<Static<TestType>::template OfSize>(solves_well, StaticSizes<TestType>{});
}

TEMPLATE_TEST_CASE("a singular matrix or a bad entry is refused", "", float, double, long double) {
  dense::for_sizes<Static<TestType>::template OfSize>(refuses, StaticSizes<TestType>{});
}

TEMPLATE_TEST_CASE("it solves in place", "", float, double, long double) {
  dense::for_sizes<Static<TestType>::template OfSize>(dense::solves_where_x_lies, StaticSizes<TestType>{});
}

#endif
