// Rosenbrock schemes: their order conditions, their order, what a step costs, and what it leaves of stiff components.
#include <phistep/sparse.hpp>

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "convergence/observed_order.hpp"
#include "problems/dahlquist.hpp"
#include "problems/forced.hpp"
#include "problems/hires.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::march;
using Vec = Eigen::VectorXd;

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
using Column = Eigen::Matrix<Number, Eigen::Dynamic, 1>;
using Square = Eigen::Matrix<Number, Eigen::Dynamic, Eigen::Dynamic>;

/// The untransformed coefficients: with Γ = (γ_ij), a = A Γ⁻¹, c = diag(1/γ) − Γ⁻¹, m = b Γ⁻¹.
template <class T>
struct Original {
  Square A, Gamma, beta;
  Column b, b_embedded;
  Original() {
    constexpr int s = T::stages;
    Square a(s, s), inverse(s, s);
    Column m(s), m_embedded(s);
    for (int i = 0; i < s; ++i) {
      for (int j = 0; j < s; ++j) {
        a(i, j) = j < i ? T::a[i][j] : 0;
        inverse(i, j) = (i == j ? 1 / T::gamma : 0) - (j < i ? T::c[i][j] : 0);
      }
      m[i] = i < s - 1 ? T::a[s - 1][i] : 1;
      m_embedded[i] = i < s - 1 ? T::a[s - 1][i] : 0;
    }
    Gamma = inverse.inverse();
    A = a * Gamma;
    beta = A + Gamma;
    b = Gamma.transpose() * m;
    b_embedded = Gamma.transpose() * m_embedded;
  }
  [[nodiscard]] Column weight(const Tree& t) const {
    Column all = Column::Ones(b.size());
    for (const Tree& son : t.sons) all = all.cwiseProduct((t.sons.size() == 1 ? beta : A) * weight(son)).eval();
    return all;
  }
  /// The largest defect of all conditions of order p.
  [[nodiscard]] double defect(const Column& weights, int p) const {
    Number worst = 0;
    for (const Tree& t : trees(p)) worst = std::max(worst, std::abs(weights.dot(weight(t)) - 1 / t.density()));
    return static_cast<double>(worst);
  }
};

template <class T>
void check_conditions(double rounding) {
  const Original<T> scheme;
  for (int p = 1; p <= T::order; ++p) {
    CAPTURE(p);
    CHECK(scheme.defect(scheme.b, p) <= rounding);
    if (p < T::order) CHECK(scheme.defect(scheme.b_embedded, p) <= rounding);
  }
  CHECK(scheme.defect(scheme.b, T::order + 1) > 1e-4);
  CHECK(scheme.defect(scheme.b_embedded, T::order) > 1e-4);
  for (int i = 0; i < T::stages; ++i) {
    CHECK(static_cast<double>(std::abs(scheme.A.row(i).sum() - T::alpha[i])) <= rounding);
    CHECK(static_cast<double>(std::abs(scheme.Gamma.row(i).sum() - T::gammas[i])) <= rounding);
  }
}

void for_each_scheme(auto&& f) { f(rodas4), f(rodas5p); }

/// (r, v) as one first-order vector.
struct FirstOrderForced {
  using Moved = problems::ForcedMotion<>;
  Eigen::Vector4d operator()(const Eigen::Vector4d& y, double t) const {
    Eigen::Vector4d rate;
    rate << y.tail<2>(), Moved{}(y.head<2>(), y.tail<2>(), t) / Moved::mass;
    return rate;
  }
};

/// A chain of springs and dashpots between walls, with K and C entry by entry: as dense, banded and sparse matrices.
struct Chain : ForceTerm {
  static constexpr bool uses_time = false;
  static double pull(double d) { return 40 * d + 30 * d * d * d; }
  static double slope(double d) { return 40 + 90 * d * d; }
  void add(double, const auto& y, auto& out) const {
    const auto n = y.r.size();
    for (Index i = 0; i <= n; ++i) {
      const double d = (i < n ? y.r[i] : 0) - (i > 0 ? y.r[i - 1] : 0),
                   w = (i < n ? y.v[i] : 0) - (i > 0 ? y.v[i - 1] : 0);
      const double f = pull(d) + 0.7 * w;
      if (i < n) out.force[i] -= f;
      if (i > 0) out.force[i - 1] += f;
    }
  }
  void add_jacobian(double, const auto& y, auto& sink) const {
    const auto n = y.r.size();
    const auto put = [&](Index i, Index j, double k, double c) {
      sink.position(i, j, k);
      sink.velocity(i, j, c);
    };
    for (Index i = 0; i <= n; ++i) {
      const double k = slope((i < n ? y.r[i] : 0) - (i > 0 ? y.r[i - 1] : 0));
      if (i < n) put(i, i, -k, -0.7);
      if (i > 0) put(i - 1, i - 1, -k, -0.7);
      if (i < n && i > 0) put(i, i - 1, k, 0.7), put(i - 1, i, k, 0.7);
    }
  }
};
struct BandedChain : Chain {
  static constexpr Structure structure = Structure::banded;
};
struct SparseChain : Chain {
  static constexpr Structure structure = Structure::sparse;
};

}  // namespace

TEST_CASE("the order conditions of all trees, for the step and for its embedded estimate") {
  REQUIRE(trees(5).size() == 9);
  REQUIRE(trees(6).size() == 20);
  // Printed to 16 digits, some of them of numbers around 300.
  check_conditions<Rodas4>(1e-12);
  check_conditions<Rodas5P>(1e-12);
}

// Jacobians by differences leave 1e-8 of h² in each step: below 1e-11 that is what is seen.
TEST_CASE("order 4 and 5: a flow and a damped motion, nonlinear, non-autonomous, with a mass") {
  using Flow = problems::ForcedFlow<>;
  using Moved = problems::ForcedMotion<>;
  for_each_scheme([](auto scheme) {
    const int p = scheme.order();
    CAPTURE(p);
    check_order(errors(p == 4 ? 20 : 30,
                       [&](int n) {
                         const auto y = Flow::exact(0);
                         PhiStepper stepper{y, Flow{}, scheme, capacity(Flow::capacity)};
                         return distance(march(stepper, y, 0.0, 2.0, n), Flow::exact(2));
                       }),
                p, 0.2);
    check_order(errors(p == 4 ? 20 : 30,
                       [&](int n) {
                         const auto y = Moved::exact(0);
                         PhiStepper stepper{y, Moved{}, scheme, mass(Moved::mass)};
                         return distance(march(stepper, y, 0.0, 2.0, n), Moved::exact(2));
                       }),
                p, 0.2);
  });
}

TEST_CASE("a motion of n unknowns is the first-order system of 2n") {
  using Moved = problems::ForcedMotion<>;
  auto motion = Moved::exact(0);
  Eigen::Vector4d y;
  y << motion.r, motion.v;
  motion = march(PhiStepper{motion, Moved{}, rodas4, mass(Moved::mass)}, motion, 0.0, 1.0, 10);
  y = march(PhiStepper{y, FirstOrderForced{}, rodas4}, y, 0.0, 1.0, 10);
  // Jacobians by differences, of other increments: equal to √u of what they change a step by.
  CHECK((motion.r - y.head<2>()).norm() <= 1e-8);
  CHECK((motion.v - y.tail<2>()).norm() <= 1e-8);
}

TEST_CASE("dense, banded and sparse tangents give the same motion, with masses") {
  constexpr int n = 12;
  const Vec masses = Vec::LinSpaced(n, 1, 3);
  const Motion<Vec> start{Vec::LinSpaced(n, -0.3, 0.2), Vec::Ones(n)};
  const auto run = [&](auto force) {
    auto y = start;
    PhiStepper stepper{y, force, rodas4, mass(masses)};
    return march(stepper, y, 0.0, 1.0, 20);
  };
  const auto dense = run(Chain{}), banded = run(BandedChain{}), sparse = run(SparseChain{});
  CHECK(distance(dense, start) > 0.1);
  CHECK(distance(dense, banded) <= 1e-13);
  CHECK(distance(dense, sparse) <= 1e-13);
}

TEST_CASE("what a step costs, and what a rejected one leaves for the next try") {
  auto y = problems::Hires::start();
  PhiStepper stepper{y, problems::Hires{}, rodas5p};
  REQUIRE(stepper.step(y, 0.0, 1e-3));
  CHECK(stepper.statistics().force_calls == 8);
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 1);
  CHECK(stepper.statistics().solves == 8);

  Trace<problems::Hires::State> trace;
  trace.resize(y);
  const auto before = y;
  CHECK(stepper.attempt(y, 1e-3, 1.0, Origin::unknown, trace, [](auto&...) { return false; }).outcome() ==
        Outcome::error_too_large);
  CHECK(y == before);
  const auto tried = stepper.statistics();
  REQUIRE(stepper.attempt(y, 1e-3, 1e-3, Origin::unknown, trace, [](auto&...) { return true; }));
  CHECK(stepper.statistics().force_calls - tried.force_calls == 7);  // Ψ and J were there
  CHECK(stepper.statistics().jacobians == tried.jacobians);
  CHECK(stepper.statistics().factorizations == tried.factorizations + 1);

  // And the step is the one of a stepper that was never refused.
  auto z = before;
  PhiStepper fresh{z, problems::Hires{}, rodas5p};
  REQUIRE(fresh.step(z, 1e-3, 1e-3));
  CHECK(y == z);
  // An edit is seen.
  y = before;
  CHECK_FALSE(stepper.attempt(y, 1e-3, 1e-3, Origin::unknown, trace, [](auto&...) { return false; }));
  y[0] *= 2, z = y;
  REQUIRE(stepper.step(y, 1e-3, 1e-3));
  REQUIRE(PhiStepper{z, problems::Hires{}, rodas5p}.step(z, 1e-3, 1e-3));
  CHECK(y == z);
}

TEST_CASE("an affine force is linearised once, and factorised again only where dt changes") {
  Vec y = Vec::Ones(3);
  const Eigen::MatrixXd K{{-3.0, 1.0, 0.0}, {1.0, -2.0, 0.5}, {0.0, 0.5, -1.0}};
  PhiStepper stepper{y, linear(K), rodas4};
  for (int k = 0; k < 10; ++k) REQUIRE(stepper.step(y, 0.1 * k, 0.1));
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 1);
  REQUIRE(stepper.step(y, 1.0, 0.05));
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 2);
}

TEST_CASE("L-stable: nothing is left of what is infinitely stiff, and nothing grows on the left half-plane") {
  for_each_scheme([](auto scheme) {
    const auto amplification = [&](double z) {
      const problems::Dahlquist problem{z};
      problems::Dahlquist::State y{1};
      PhiStepper stepper{y, problem, scheme};
      problems::step(stepper, y, 0.0, 1.0);
      return y[0];
    };
    CHECK(std::abs(amplification(-1e10)) <= 1e-8);
    for (double z = -1e-3; z > -1e9; z *= 3) CHECK(std::abs(amplification(z)) <= 1);
    CHECK(amplification(-0.1) == Approx(std::exp(-0.1)).epsilon(1e-6));
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
  using Flow = problems::ForcedFlow<>;
  for_each_scheme([](auto scheme) {
    const auto error = [&](int n) {
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
        if (!stepper.attempt(y, k * h, h, Origin::unknown, trace, [](auto&...) { return true; })) return HUGE_VAL;
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
    check_order(errors(20, error), scheme.order(), 0.2);
  });
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
