// Rosenbrock schemes: their order conditions, their order, what a step costs, and what it leaves of stiff components.
#include <phistep/particles.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <vector>

#include "accuracy/observed_order.hpp"
#include "problems/dahlquist.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#if PHISTEP_QUICK
#include "problems/prothero_robinson.hpp"
#endif
#if PHISTEP_FULL
#include "problems/hires.hpp"
#endif

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::march;

namespace rosenbrock_cases {

/// Accepts every try, or none: one type, so that attempt is compiled once for each stepper.
struct Verdict {
  bool accepts;
  bool operator()(const auto&...) const { return accepts; }
};

// Errors at t = 2 of a flow and of a damped motion, nonlinear, non-autonomous, with a mass, in n steps.
double flow_error(auto scheme, int n) {
  using Flow = problems::ForcedFlow<>;
  const auto y = Flow::exact(0);
  PhiStepper stepper{y, Flow{}, scheme, capacity(Flow::capacity)};
  return distance(march(stepper, y, 0.0, 2.0, n), Flow::exact(2));
}
double motion_error(auto scheme, int n) {
  using Moved = problems::ForcedMotion<>;
  const auto y = Moved::exact(0);
  PhiStepper stepper{y, Moved{}, scheme, mass(Moved::mass)};
  return distance(march(stepper, y, 0.0, 2.0, n), Moved::exact(2));
}

/// @param calls  of the force, a step
template <class State>
void check_cost(const State& start, const auto& force, auto scheme, int calls) {
  State y = start;
  PhiStepper stepper{y, force, scheme};
  REQUIRE(stepper.step(y, 0.0, 1e-3));
  CHECK(stepper.statistics().force_calls == calls);
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 1);
  CHECK(stepper.statistics().solves == calls);

  Trace<State> trace;
  trace.resize(y);
  const auto before = y;
  CHECK(stepper.attempt(y, 1e-3, 1.0, Origin::unknown, trace, Verdict{false}).outcome() == Outcome::error_too_large);
  CHECK(y == before);
  const auto tried = stepper.statistics();
  REQUIRE(stepper.attempt(y, 1e-3, 1e-3, Origin::unknown, trace, Verdict{true}));
  CHECK(stepper.statistics().force_calls - tried.force_calls ==
        calls);  // Ψ and J were there, Ψ at the end is the next step's
  CHECK(stepper.statistics().jacobians == tried.jacobians);
  CHECK(stepper.statistics().factorizations == tried.factorizations + 1);

  // And the step is the one of a stepper that was never refused.
  auto z = before;
  PhiStepper fresh{z, force, scheme};
  REQUIRE(fresh.step(z, 1e-3, 1e-3));
  CHECK(y == z);
  // An edit is seen.
  y = before;
  CHECK_FALSE(stepper.attempt(y, 1e-3, 1e-3, Origin::unknown, trace, Verdict{false}));
  y[0] *= 2, z = y;
  REQUIRE(stepper.step(y, 1e-3, 1e-3));
  REQUIRE(PhiStepper{z, force, scheme}.step(z, 1e-3, 1e-3));
  CHECK(y == z);
}

/// @param amplification  by a step, of z = λΔt
inline void check_l_stable(const std::function<double(double z)>& amplification) {
  CHECK(std::abs(amplification(-1e10)) <= 1e-8);
  for (double z = -1e-3; z > -1e9; z *= 3) CHECK(std::abs(amplification(z)) <= 1);
  CHECK(amplification(-0.1) == Approx(std::exp(-0.1)).epsilon(1e-6));
}

/// The largest error inside of steps that start on the solution.
double dense_error(auto scheme, int n) {
  using Flow = problems::ForcedFlow<>;
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
}

}  // namespace rosenbrock_cases

using namespace rosenbrock_cases;

#if PHISTEP_QUICK

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

#elif PHISTEP_FULL
// Rosenbrock schemes: orders, stability and dense output of each, in every scalar.

namespace {

void for_each_scheme(auto&& f) { f(rodas4), f(rodas5p); }

}  // namespace

// Jacobians by differences leave 1e-8 of h² in each step: below 1e-11 that is what is seen.
TEST_CASE("order 4 and 5: a flow and a damped motion, nonlinear, non-autonomous, with a mass") {
  for_each_scheme([](auto scheme) {
    const int p = scheme.order(), coarsest = p == 4 ? 20 : 30;
    CAPTURE(p);
    check_order(errors(coarsest, [&](int n) { return flow_error(scheme, n); }), p, 0.2);
    check_order(errors(coarsest, [&](int n) { return motion_error(scheme, n); }), p, 0.2);
  });
}

namespace {
struct SpringsAndCooling : ForceTerm {
  static void add(double, const auto& y, auto& out) {
    out.force -= 4 * y.r;
    out.heat -= 2 * y.temperature;
  }
};
}  // namespace

TEST_CASE("particles that heat up: more unknowns than positions") {
  Particles<double, 3, Temperature> y{Eigen::Matrix3Xd::Constant(3, 4, 1.0)};
  y.temperature.setConstant(1);
  PhiStepper stepper{y, SpringsAndCooling{}, rodas4};
  for (int n = 0; n < 100; ++n) problems::step(stepper, y, 0.01 * n, 0.01);
  CHECK((y.r.array() - std::cos(2.0)).abs().maxCoeff() < 1e-7);
  CHECK((y.temperature.array() - std::exp(-2.0)).abs().maxCoeff() < 1e-7);
}

TEST_CASE("particles held still: their force says nothing of the Jacobian") {
  Particles<double, 3> chain{Eigen::Matrix3Xd{{0, 1.2, 2.1}, {0, 0, 0}, {0, 0, 0}}};
  chain.set_still({1, 0, 0});
  const auto force = [](const Eigen::Matrix3Xd& r) -> Eigen::Matrix3Xd {  // springs of length 1, nonlinear
    Eigen::Matrix3Xd f = Eigen::Matrix3Xd::Zero(3, 3);
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector3d d = r.col(i + 1) - r.col(i), pull = 10 * (d.norm() - 1) * d.normalized();
      f.col(i) += pull, f.col(i + 1) -= pull;
    }
    return f;
  };
  PhiStepper pulled{chain, banded(force, 8, 8), rodas4};
  auto bound = chain;
  REQUIRE(integrate(pulled, bound, {0.0, 1.0}, tolerance{.rtol = 1e-8}));
  CHECK(pulled.statistics().checks > 0);
  PhiStepper reference{chain, force, tsit5};
  auto other = chain;
  REQUIRE(integrate(reference, other, {0.0, 1.0}, tolerance{.rtol = 1e-10}));
  CHECK((bound.r - other.r).norm() <= 1e-6);
  CHECK(bound.r.col(0).norm() <= 1e-30);
}

TEST_CASE("what a step costs, and what a rejected one leaves for the next try") {
  check_cost(problems::Hires::start(), problems::Hires{}, rodas5p, 8);
}

TEST_CASE("L-stable: nothing is left of what is infinitely stiff, and nothing grows on the left half-plane") {
  for_each_scheme([](auto scheme) {
    check_l_stable([&](double z) {
      const problems::Dahlquist problem{z};
      problems::Dahlquist::State y{1};
      PhiStepper stepper{y, problem, scheme};
      problems::step(stepper, y, 0.0, 1.0);
      return y[0];
    });
  });
  // Oscillators: A-stable along the imaginary axis. K is a difference, good to √u.
  using One = Eigen::Matrix<double, 1, 1>;
  for (double omega = 1e-2; omega < 1e6; omega *= 3) {
    Motion<One> y{One{1.0}, One{0.0}};
    PhiStepper stepper{y, [omega](const One& r) -> One { return -omega * omega * r; }, rodas5p};
    problems::step(stepper, y, 0.0, 1.0);
    CHECK(std::hypot(y.r[0], y.v[0] / omega) <= 1 + 1e-7);
  }
}

TEST_CASE("dense output: order 3 and 4 inside the step, and its ends") {
  // A continuous extension of order q leaves h^{q+1} inside of one step.
  for_each_scheme(
      [](auto scheme) { check_order(errors(20, [&](int n) { return dense_error(scheme, n); }), scheme.order(), 0.2); });
}

TEMPLATE_TEST_CASE("every scalar: order 4 above the floor of its rounding", "", float, long double) {
  using T = TestType;
  using Flow = problems::ForcedFlow<T>;
  const auto e = errors(2, [](int n) {
    const auto y = Flow::exact(0);
    PhiStepper stepper{y, Flow{}, rodas4, capacity(T(Flow::capacity))};
    return distance(march(stepper, y, T(0), T(2), n), Flow::exact(2));
  });
  CHECK(e[0] / e[2] > std::exp2(2 * 3.2));
  CHECK(e[0] / e[2] < std::exp2(2 * 5.0));
}

TEST_CASE("where double precision ends, it says so") {
  auto y = problems::Hires::start();
  PhiStepper stepper{y, problems::Hires{}, rodas5p};
  CHECK(integrate(stepper, y, {0.0, 1e-3}, tolerance{.rtol = 1e-14, .atol = 1e-18}).outcome ==
        Outcome::invalid_tolerance);
  CHECK(y == problems::Hires::start());
  CHECK(integrate(stepper, y, {0.0, 1e-3}, tolerance{.rtol = 1e-13, .atol = 1e-17}));
}

#endif
