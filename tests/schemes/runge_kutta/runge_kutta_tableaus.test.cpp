// The published coefficients: all order conditions of the pairs and of their dense output, and where they end.
#include "phistep/schemes/runge_kutta/runge_kutta_tableaus.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include "phistep/schemes/runge_kutta/runge_kutta.hpp"
#include "schemes/runge_kutta/rooted_trees.hpp"
#include "support/catch.hpp"

using namespace phistep;
using rooted_trees::Tree;
using rooted_trees::trees;

namespace {

using Weights = std::vector<long double>;

/// Σ_j w_j Φ_j(t) − x^n/γ(t), over the largest term
template <class Tableau>
long double defect(const Weights& w, const Tree& tree, long double x = 1) {
  const auto phi = tree.weights<Tableau>();
  long double sum = -std::pow(x, static_cast<long double>(tree.size())) / tree.gamma(), largest = 1;
  for (std::size_t j = 0; j < w.size(); ++j) {
    sum += w[j] * phi[j];
    largest = std::max(largest, std::abs(w[j] * phi[j]));
  }
  return std::abs(sum) / largest;
}
template <class Tableau>
long double worst_defect(const Weights& w, int vertices, long double x = 1) {
  long double worst = 0;
  for (const Tree& tree : trees(vertices)) worst = std::max(worst, defect<Tableau>(w, tree, x));
  return worst;
}
/// Up to that order, and no higher.
template <class Tableau>
void check_order(const Weights& w, int order) {
  // The printed digits of DOP853 are thirty, sums of sixteen large terms lose some of long double's nineteen.
  constexpr long double u = 100 * std::numeric_limits<long double>::epsilon();
  for (int n = 1; n <= order; ++n) {
    CAPTURE(n);
    CHECK(worst_defect<Tableau>(w, n) <= u);
  }
  CHECK(worst_defect<Tableau>(w, order + 1) > 1e-8L);
}
template <class Tableau>
Weights b() {
  return {Tableau::a[Tableau::end], Tableau::a[Tableau::end] + Tableau::stages};
}
template <class Tableau>
using Error = TableRow<Tableau::e, 0, std::size(Tableau::e[0])>;
using ErrorOfOrder3 =
    DifferenceOfWeights<TableRow<Dop853::a, Dop853::end, Dop853::end>, TableRow<Dop853::b_3, 0, Dop853::end>>;
/// b̂ = b − e
template <class Estimate>
Weights lower(Weights b) {
  for (std::size_t j = 0; j < Estimate::count; ++j) b[j] -= Estimate::at(j);
  return b;
}
template <class Tableau>
void check_rows() {
  for (std::size_t i = 0; i < Tableau::stages; ++i) {
    long double sum = -Tableau::c[i];
    for (std::size_t j = 0; j < i; ++j) sum += Tableau::a[i][j];
    CHECK(std::abs(sum) <= 400 * std::numeric_limits<long double>::epsilon());  // terms of up to 43
  }
}
template <class Tableau>
void check_inside(int order) {
  for (const long double x : {0.1L, 0.35L, 0.5L, 0.77L, 1.0L}) {
    CAPTURE(x);
    const auto w = RungeKuttaInterpolant<Tableau>::weights(x);
    for (int n = 1; n <= order; ++n)
      CHECK(worst_defect<Tableau>({w.begin(), w.end()}, n, x) <= 1000 * std::numeric_limits<long double>::epsilon());
    if (x < 1) CHECK(worst_defect<Tableau>({w.begin(), w.end()}, order + 1, x) > 1e-8L);
  }
}

}  // namespace

TEST_CASE("rooted trees are numbered as in the book") {
  const std::vector<std::size_t> numbers{1, 1, 2, 4, 9, 20, 48, 115};
  for (int n = 1; n <= 8; ++n) CHECK(trees(n).size() == numbers[static_cast<std::size_t>(n - 1)]);
  CHECK(trees(3)[0].gamma() + trees(3)[1].gamma() == 9);  // 3 and 6
}

TEST_CASE("Tsitouras 5(4) meets all conditions of its orders") {
  check_rows<Tsit5>();
  check_order<Tsit5>(b<Tsit5>(), 5);
  check_order<Tsit5>(lower<Error<Tsit5>>(b<Tsit5>()), 4);
  check_inside<Tsit5>(4);
}

TEST_CASE("Dormand and Prince 8(5,3) meets all conditions of its orders") {
  check_rows<Dop853>();
  check_order<Dop853>(b<Dop853>(), 8);
  check_order<Dop853>(lower<Error<Dop853>>(b<Dop853>()), 5);
  check_order<Dop853>(lower<ErrorOfOrder3>(b<Dop853>()), 3);
  check_inside<Dop853>(7);
}
