#include "step/matrix/static_sparse_lu_cases.hpp"

using namespace static_sparse_lu_cases;

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
  constexpr EliminationPlan<n> arrow{Arrow<n>::pattern};
  STATIC_REQUIRE(arrow.slots == 3 * n - 2);
  STATIC_REQUIRE(arrow.products == n - 1);
  STATIC_REQUIRE(arrow(1, 2) == EliminationPlan<n>::none);
  constexpr EliminationPlan<5> full{Full<5>::pattern};
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
    fill(chain.solver().matrix(), Chain::pattern);
    fill(arrow.solver().matrix(), Arrow<12>::pattern);
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
  for (const MatrixEntry& e : Chain::pattern) A(e.row, e.column) = 0.5 + 0.01 * e.row;
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
