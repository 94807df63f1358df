// Rosenbrock schemes: their order conditions, their order, what a step costs, and what it leaves of stiff components.
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <vector>

#include "problems/prothero_robinson.hpp"
#include "schemes/rosenbrock_cases.hpp"

using namespace rosenbrock_cases;

namespace {

// Order conditions (Hairer & Wanner II, sect. IV.7, theorem 7.4): for each rooted tree τ with up to p nodes,
// Σ_i b_i Φ_i(τ) = 1/γ(τ). Φ is a product over sons: a node with one son passes it on by β_ij = α_ij + γ_ij, one with
// several by α_ij.
struct Tree {
  std::vector<Tree> sons;
  [[nodiscard]] int nodes() const {
    int n = 1;
    for (const Tree& son : sons) n += son.nodes();
    return n;
  }
  [[nodiscard]] long double density() const {
    long double all = nodes();
    for (const Tree& son : sons) all *= son.density();
    return all;
  }
};
/// All trees of n nodes, each once: sons in descending order of a running number.
std::vector<Tree> trees(int n) {
  if (n == 1) return {Tree{}};
  std::vector<Tree> smaller;
  for (int m = 1; m < n; ++m)
    for (const Tree& t : trees(m)) smaller.push_back(t);
  std::vector<Tree> all;
  const std::function<void(Tree, std::size_t, int)> grow = [&](const Tree& so_far, std::size_t from, int left) {
    if (left == 0) return all.push_back(so_far);
    for (std::size_t k = from; k < smaller.size(); ++k) {
      if (smaller[k].nodes() > left) continue;
      Tree next = so_far;
      next.sons.push_back(smaller[k]);
      grow(next, k, left - smaller[k].nodes());
    }
  };
  grow(Tree{}, 0, n - 1);
  return all;
}

using Number = long double;
using Column = std::vector<Number>;
using Square = std::vector<Column>;  // rows; loops, because Eigen's products in long double take seconds to compile

/// The untransformed coefficients: with Γ = (γ_ij), a = A Γ⁻¹, c = diag(1/γ) − Γ⁻¹, m = b Γ⁻¹.
struct Original {
  std::size_t s;
  Square A, Gamma, beta;
  Column b, b_embedded;
  template <class T>
  explicit Original(T) : s(T::stages), A(s, Column(s, 0)), Gamma(A), beta(A), b(s, 0), b_embedded(s, 0) {
    Square a = A, inverse = A;
    Column m(s), m_embedded(s);
    for (std::size_t i = 0; i < s; ++i) {
      for (std::size_t j = 0; j < s; ++j) {
        a[i][j] = j < i ? T::a[i][j] : 0;
        inverse[i][j] = (i == j ? 1 / T::gamma : 0) - (j < i ? T::c[i][j] : 0);
      }
      m[i] = i < s - 1 ? T::a[s - 1][i] : 1;
      m_embedded[i] = i < s - 1 ? T::a[s - 1][i] : 0;
    }
    untransform(a, inverse, m, m_embedded);
  }
  void untransform(const Square& a, const Square& inverse, const Column& m, const Column& m_embedded) {
    for (std::size_t j = 0; j < s; ++j)  // Γ, column by column: its inverse is lower triangular
      for (std::size_t i = j; i < s; ++i) {
        Number left = i == j ? 1 : 0;
        for (std::size_t k = j; k < i; ++k) left -= inverse[i][k] * Gamma[k][j];
        Gamma[i][j] = left / inverse[i][i];
      }
    for (std::size_t j = 0; j < s; ++j)
      for (std::size_t i = 0; i < s; ++i) {
        for (std::size_t k = 0; k < s; ++k) A[i][j] += a[i][k] * Gamma[k][j];
        beta[i][j] = A[i][j] + Gamma[i][j];
        b[j] += Gamma[i][j] * m[i];
        b_embedded[j] += Gamma[i][j] * m_embedded[i];
      }
  }
  [[nodiscard]] Column weight(const Tree& t) const {
    Column all(s, 1);
    for (const Tree& son : t.sons) {
      const Column w = weight(son);
      const Square& by = t.sons.size() == 1 ? beta : A;
      for (std::size_t i = 0; i < s; ++i) {
        Number sum = 0;
        for (std::size_t j = 0; j < s; ++j) sum += by[i][j] * w[j];
        all[i] *= sum;
      }
    }
    return all;
  }
  /// The largest defect of all conditions of order p.
  [[nodiscard]] double defect(const Column& weights, int p) const {
    Number worst = 0;
    for (const Tree& t : trees(p)) {
      const Column w = weight(t);
      Number sum = -1 / t.density();
      for (std::size_t i = 0; i < s; ++i) sum += weights[i] * w[i];
      worst = std::max(worst, std::abs(sum));
    }
    return static_cast<double>(worst);
  }
};

void check_conditions(const Original& scheme, int order, const Column& alpha, const Column& gammas, double rounding) {
  for (int p = 1; p <= order; ++p) {
    CAPTURE(p);
    CHECK(scheme.defect(scheme.b, p) <= rounding);
    if (p < order) CHECK(scheme.defect(scheme.b_embedded, p) <= rounding);
  }
  CHECK(scheme.defect(scheme.b, order + 1) > 1e-4);
  CHECK(scheme.defect(scheme.b_embedded, order) > 1e-4);
  for (std::size_t i = 0; i < scheme.s; ++i) {
    const Column &a = scheme.A[i], &c = scheme.Gamma[i];
    CHECK(static_cast<double>(std::abs(std::accumulate(a.begin(), a.end(), Number(0)) - alpha[i])) <= rounding);
    CHECK(static_cast<double>(std::abs(std::accumulate(c.begin(), c.end(), Number(0)) - gammas[i])) <= rounding);
  }
}
template <class T>
void check_conditions(double rounding) {
  check_conditions(Original(T{}), T::order, Column(std::begin(T::alpha), std::end(T::alpha)),
                   Column(std::begin(T::gammas), std::end(T::gammas)), rounding);
}

}  // namespace

TEST_CASE("the order conditions of all trees, for the step and for its embedded estimate") {
  REQUIRE(trees(5).size() == 9);
  REQUIRE(trees(6).size() == 20);
  // Printed to 16 digits, some of them of numbers around 300.
  check_conditions<Rodas4>(1e-12);
  check_conditions<Rodas4P2>(1e-12);
  check_conditions<Rodas5P>(1e-12);
}

// Jacobians by differences leave 1e-8 of h² in each step: below 1e-11 that is what is seen.
TEST_CASE("order 4 and 5: a flow and a damped motion, nonlinear, non-autonomous, with a mass") {
  check_order(errors(30, [](int n) { return flow_error(rodas5p, n); }), 5, 0.2);
  check_order(errors(20, [](int n) { return motion_error(rodas4, n); }), 4, 0.2);
  check_order(errors(20, [](int n) { return flow_error(rodas4p2, n); }), 4, 0.2);
}

TEST_CASE("driven by time and stiff: rodas4's estimate goes as the step, those of rodas4p2 and rodas5p as its cube") {
  using P = problems::ProtheroRobinson;
  const auto order = [](auto scheme) {
    const auto estimate = [&](double h) {
      P::State y = P::exact(1);
      PhiStepper stepper{y, P{-1e7}, scheme};
      Trace<P::State> trace;
      trace.resize(y);
      REQUIRE(stepper.attempt(y, 1.0, h, Origin::unknown, trace, Verdict{true}));
      return std::abs(trace.error[0]);
    };
    return std::log2(estimate(0.02) / estimate(0.01));
  };
  const double of_4 = order(rodas4), of_4p2 = order(rodas4p2), of_5p = order(rodas5p);
  CAPTURE(of_4, of_4p2, of_5p);
  CHECK(std::abs(of_4 - 1) < 0.2);
  CHECK(of_4p2 > 2.8);
  CHECK(of_5p > 2.8);
  const auto steps = [](auto scheme, double rtol) {
    P::State y = P::exact(0);
    PhiStepper stepper{y, P{-1e3}, scheme};
    const RunReport report = integrate(stepper, y, {0, 10}, tolerance{.rtol = rtol, .atol = rtol});
    REQUIRE(report);
    CHECK(std::abs(y[0] - P::exact(10)[0]) < 5 * rtol);
    return report.statistics.steps;
  };
  for (const double rtol : {1e-6, 1e-8}) {
    const auto of_rodas4 = steps(rodas4, rtol), of_rodas4p2 = steps(rodas4p2, rtol);
    CAPTURE(rtol, of_rodas4, of_rodas4p2);
    CHECK(of_rodas4p2 < of_rodas4 / 3);
  }
}

TEST_CASE("particles held still: their force says nothing of the Jacobian") {
  Particles<double, 3> chain{Eigen::Matrix3Xd{{0, 1.2, 2.1}, {0, 0, 0}, {0, 0, 0}}};
  chain.set_still({1, 0, 0});
  // A Jacobian that is supplied is checked; a gravity that is affine has one.
  PhiStepper falling{chain, Gravity{Eigen::Vector3d{0, 0, -9.81}}, rodas4};
  auto fallen = chain;
  REQUIRE(integrate(falling, fallen, {0.0, 1.0}, fixed(0.1)));
  CHECK(falling.statistics().checks > 0);
  CHECK(fallen.r.col(0).norm() <= 1e-30);
  CHECK(fallen.r(2, 1) == Approx(-9.81 / 2).epsilon(1e-12));
}

TEST_CASE("what a step costs, and what a rejected one leaves for the next try") {
  using Linear = problems::ComplexDahlquist;
  check_cost(Linear::State{1, 0.5}, Linear{{-2.0, 1.0}}, rodas4, 6);
}

TEST_CASE("L-stable: nothing is left of what is infinitely stiff, and nothing grows on the left half-plane") {
  check_l_stable([](double z) {
    const problems::ComplexDahlquist problem{{z, 0}};
    problems::ComplexDahlquist::State y{1, 0};
    PhiStepper stepper{y, problem, rodas4};
    problems::step(stepper, y, 0.0, 1.0);
    return y[0];
  });
}

TEST_CASE("dense output: order 3 and 4 inside the step, and its ends") {
  // A continuous extension of order q leaves h^{q+1} inside of one step.
  check_order(errors(20, [](int n) { return dense_error(rodas5p, n); }), 5, 0.2);
  check_order(errors(20, [](int n) { return dense_error(rodas4p2, n); }), 4, 0.2);
}

TEST_CASE("a force that jumps where a step starts has no slope there: order 1, not the jump divided by a difference") {
  using One = Eigen::Matrix<double, 1, 1>;
  const auto check = [](auto scheme, bool is_late) {
    const auto heater = [is_late](const One& y, double t) {
      return One{-y[0] + ((is_late ? t > 1.0 : t >= 1.0) ? 1.0 : 0.0)};
    };
    double before = 0;
    for (const double dt : {0.25, 0.125, 0.0625}) {
      One y{0.0};
      PhiStepper stepper{y, heater, scheme};
      REQUIRE(integrate(stepper, y, {0.0, 2.0}, fixed(dt)));
      const double error = std::abs(y[0] - (1 - std::exp(-1.0)));
      CAPTURE(dt, is_late, error);
      CHECK(error < 0.5 * dt);
      if (before > 0) CHECK(error < 0.7 * before);
      before = error;
    }
  };
  for (const bool is_late : {false, true}) check(rodas4, is_late), check(rodas4p2, is_late), check(rodas5p, is_late);
}
