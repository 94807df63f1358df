// Rosenbrock schemes: their order conditions, their order, what a step costs, and what it leaves of stiff components.
#include <phistep/particles.hpp>
#include <phistep/phistep.hpp>

#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <vector>

#include "convergence/observed_order.hpp"
#include "problems/dahlquist.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "problems/prothero_robinson.hpp"
#include "support/catch.hpp"

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::march;

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

/// Accepts every try, or none: one type, so that attempt is compiled once for each stepper.
struct Verdict {
  bool accepts;
  bool operator()(const auto&...) const { return accepts; }
};

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
  using Flow = problems::ForcedFlow<>;
  using Moved = problems::ForcedMotion<>;
  check_order(errors(30,
                     [](int n) {
                       const auto y = Flow::exact(0);
                       PhiStepper stepper{y, Flow{}, rodas5p, capacity(Flow::capacity)};
                       return distance(march(stepper, y, 0.0, 2.0, n), Flow::exact(2));
                     }),
              5, 0.2);
  check_order(errors(20,
                     [](int n) {
                       const auto y = Moved::exact(0);
                       PhiStepper stepper{y, Moved{}, rodas4, mass(Moved::mass)};
                       return distance(march(stepper, y, 0.0, 2.0, n), Moved::exact(2));
                     }),
              4, 0.2);
  check_order(errors(20,
                     [](int n) {
                       const auto y = Flow::exact(0);
                       PhiStepper stepper{y, Flow{}, rodas4p2, capacity(Flow::capacity)};
                       return distance(march(stepper, y, 0.0, 2.0, n), Flow::exact(2));
                     }),
              4, 0.2);
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
  const Linear force{{-2.0, 1.0}};
  Linear::State y{1, 0.5};
  PhiStepper stepper{y, force, rodas4};
  REQUIRE(stepper.step(y, 0.0, 1e-3));
  CHECK(stepper.statistics().force_calls == 6);
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 1);
  CHECK(stepper.statistics().solves == 6);

  Trace<Linear::State> trace;
  trace.resize(y);
  const auto before = y;
  CHECK(stepper.attempt(y, 1e-3, 1.0, Origin::unknown, trace, Verdict{false}).outcome() == Outcome::error_too_large);
  CHECK(y == before);
  const auto tried = stepper.statistics();
  REQUIRE(stepper.attempt(y, 1e-3, 1e-3, Origin::unknown, trace, Verdict{true}));
  CHECK(stepper.statistics().force_calls - tried.force_calls == 5);  // Ψ and J were there
  CHECK(stepper.statistics().jacobians == tried.jacobians);
  CHECK(stepper.statistics().factorizations == tried.factorizations + 1);

  // And the step is the one of a stepper that was never refused.
  auto z = before;
  PhiStepper fresh{z, force, rodas4};
  REQUIRE(fresh.step(z, 1e-3, 1e-3));
  CHECK(y == z);
  // An edit is seen.
  y = before;
  CHECK_FALSE(stepper.attempt(y, 1e-3, 1e-3, Origin::unknown, trace, Verdict{false}));
  y[0] *= 2, z = y;
  REQUIRE(stepper.step(y, 1e-3, 1e-3));
  REQUIRE(PhiStepper{z, force, rodas4}.step(z, 1e-3, 1e-3));
  CHECK(y == z);
}

TEST_CASE("L-stable: nothing is left of what is infinitely stiff, and nothing grows on the left half-plane") {
  const auto amplification = [](double z) {
    const problems::ComplexDahlquist problem{{z, 0}};
    problems::ComplexDahlquist::State y{1, 0};
    PhiStepper stepper{y, problem, rodas4};
    problems::step(stepper, y, 0.0, 1.0);
    return y[0];
  };
  CHECK(std::abs(amplification(-1e10)) <= 1e-8);
  for (double z = -1e-3; z > -1e9; z *= 3) CHECK(std::abs(amplification(z)) <= 1);
  CHECK(amplification(-0.1) == Approx(std::exp(-0.1)).epsilon(1e-6));
}

TEST_CASE("dense output: order 3 and 4 inside the step, and its ends") {
  using Flow = problems::ForcedFlow<>;
  const auto error = [](auto scheme, int n) {
    double worst = 0;
    auto y = Flow::exact(0);
    PhiStepper stepper{y, Flow{}, scheme, capacity(Flow::capacity)};
    Trace<Flow::State> trace;
    trace.resize(y);
    trace.wants_dense = true;
    const double h = 2.0 / n;
    for (int k = 0; k < n; ++k) {
      const Flow::State from = Flow::exact(k * h);  // local: what the interpolant adds to the ends' own error
      y = from;
      if (!stepper.attempt(y, k * h, h, Origin::unknown, trace, Verdict{true})) return HUGE_VAL;
      Flow::State at;
      for (const double x : {0.2, 0.5, 0.7}) {
        stepper.interpolate(x, h, from, y, at);
        worst = std::max(worst, distance(at, Flow::exact((k + x) * h)));
      }
      stepper.interpolate(1e-300, h, from, y, at);
      if (distance(at, from) > 1e-15) return HUGE_VAL;
    }
    return worst;
  };
  // A continuous extension of order q leaves h^{q+1} inside of one step.
  check_order(errors(20, [&](int n) { return error(rodas5p, n); }), 5, 0.2);
  check_order(errors(20, [&](int n) { return error(rodas4p2, n); }), 4, 0.2);
}
