// Newton without a matrix: products from the force, from automatic differentiation, from differences.
#include <phistep/autodiff.hpp>
#include <phistep/krylov.hpp>
#include <phistep/sparse.hpp>

#include <unsupported/Eigen/IterativeSolvers>

#include <cmath>
#include <random>
#include <tuple>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace {

constexpr double pi = 3.14159265358979323846;

/// u_t = Δu on the unit square, u = 0 around it, m × m inner points.
struct Heat2d {
  Index m;
  int* calls;
  int* products;

  void laplacian(const auto& u, auto& out) const {
    const double scale = static_cast<double>((m + 1) * (m + 1));
    for (Index j = 0; j < m; ++j)
      for (Index i = 0; i < m; ++i) {
        const Index at = j * m + i;
        out[at] += scale * ((i > 0 ? u[at - 1] : 0.0) + (i + 1 < m ? u[at + 1] : 0.0) + (j > 0 ? u[at - m] : 0.0) +
                            (j + 1 < m ? u[at + m] : 0.0) - 4 * u[at]);
      }
  }
  Vec operator()(const Vec& u) const {
    ++*calls;
    Vec out = Vec::Zero(u.size());
    laplacian(u, out);
    return out;
  }
};
struct HeatWithProduct : Heat2d {
  void apply_jacobian(auto /*t*/, const auto& /*y*/, const auto& x, auto& out) const {
    ++*products;
    laplacian(x.y, out.rate);
  }
};
struct HeatWithDiagonal : HeatWithProduct {
  void jacobian_diagonal(auto /*t*/, const auto& y, auto& sink) const {
    for (Index i = 0; i < y.y.size(); ++i) sink.rate(i, i, -4.0 * static_cast<double>((m + 1) * (m + 1)));
  }
};
struct HeatWithWrongSign : Heat2d {
  void apply_jacobian(auto /*t*/, const auto& /*y*/, const auto& x, auto& out) const {
    Vec product = Vec::Zero(x.y.size());
    laplacian(x.y, product);
    out.rate -= product;
  }
};

Vec mode(Index m, int a, int b) {
  Vec u(m * m);
  const double h = 1.0 / static_cast<double>(m + 1);
  for (Index j = 0; j < m; ++j)
    for (Index i = 0; i < m; ++i)
      u[j * m + i] =
          std::sin(a * pi * h * static_cast<double>(i + 1)) * std::sin(b * pi * h * static_cast<double>(j + 1));
  return u;
}
double eigenvalue(Index m, int a, int b) {
  const double n = static_cast<double>(m + 1), s = std::sin(a * pi / (2 * n)), t = std::sin(b * pi / (2 * n));
  return -4 * n * n * (s * s + t * t);
}

/// The Brusselator on a periodic grid, u_t = 1 + u²v − 4.4u + αΔu, v_t = 3.4u − u²v + αΔv (Hairer & Wanner II, sect. IV.10,
/// with α = 0.002 and without the source term); u, then v.
struct Brusselator {
  Index m;
  template <class Vector>
  Vector operator()(const Vector& y) const {
    const Index n = m * m;
    const double scale = 0.002 * static_cast<double>(m * m);
    Vector out(2 * n);
    for (Index j = 0; j < m; ++j)
      for (Index i = 0; i < m; ++i) {
        const Index at = j * m + i, w = j * m + (i + m - 1) % m, e = j * m + (i + 1) % m, s = (j + m - 1) % m * m + i,
                    t = (j + 1) % m * m + i;
        const auto u = y[at], v = y[n + at];
        out[at] = 1.0 + u * u * v - 4.4 * u + scale * (y[w] + y[e] + y[s] + y[t] - 4.0 * u);
        out[n + at] = 3.4 * u - u * u * v + scale * (y[n + w] + y[n + e] + y[n + s] + y[n + t] - 4.0 * v);
      }
    return out;
  }
  [[nodiscard]] Vec start() const {
    Vec y(2 * m * m);
    for (Index j = 0; j < m; ++j)
      for (Index i = 0; i < m; ++i) {
        const double x = static_cast<double>(i) / static_cast<double>(m),
                     z = static_cast<double>(j) / static_cast<double>(m);
        y[j * m + i] = 22 * z * std::pow(1 - z, 1.5);
        y[m * m + j * m + i] = 27 * x * std::pow(1 - x, 1.5);
      }
    return y;
  }
};

struct Chain {  // springs in a row, anharmonic, and dragged by neighbours
  Vec operator()(const Vec& r, const Vec& v) const {
    Vec f = -r.array().cube() - r.array();
    const Index n = r.size();
    f.head(n - 1) += 30 * (r.tail(n - 1) - r.head(n - 1)) + 2 * (v.tail(n - 1) - v.head(n - 1));
    f.tail(n - 1) -= 30 * (r.tail(n - 1) - r.head(n - 1)) + 2 * (v.tail(n - 1) - v.head(n - 1));
    return f;
  }
};
struct ChainWithProduct : Chain {
  void apply_jacobian(auto /*t*/, const auto& y, const auto& x, auto& out) const {
    out.force.array() -= (3 * y.r.array().square() + 1) * x.r.array();
    const Index n = y.r.size();
    const Vec pull = 30 * (x.r.tail(n - 1) - x.r.head(n - 1)) + 2 * (x.v.tail(n - 1) - x.v.head(n - 1));
    out.force.head(n - 1) += pull;
    out.force.tail(n - 1) -= pull;
  }
};
struct Nan : Heat2d {
  void apply_jacobian(auto, const auto&, const auto&, auto& out) const { out.rate[7] = NAN; }
};
struct Null {
  Vec operator()(const Vec& x) const { return Vec::Constant(x.size(), 1.0) + x; }
  void apply_jacobian(auto, const auto&, const auto& x, auto& out) const { out.rate += x.y; }
};

struct Counts {
  int calls = 0, products = 0;
};

}  // namespace

TEMPLATE_TEST_CASE("heat on 100 x 100 points without a matrix: the exact factor of an eigenvector", "",
                   (MatrixFree<Eigen::BiCGSTAB>), (MatrixFree<phistep::ConjugateGradient>),
                   (MatrixFree<Eigen::GMRES>)) {
  constexpr Index m = 100;
  Counts c;
  const double dt = 1e-3;
  const double z = eigenvalue(m, 2, 3) * dt, w = eigenvalue(m, 7, 1) * dt;
  const Vec a = mode(m, 2, 3), b = 0.5 * mode(m, 7, 1);
  const auto run = [&](auto force, double tolerance) {
    Vec y = a + b;
    PhiStepper stepper{y, force, backward_euler, newton<TestType>()};
    for (int k = 1; k <= 3; ++k) {
      const StepReport report = stepper.step(y, 0, dt);
      INFO(report.message());
      REQUIRE(report);
      const Vec exact = std::pow(1 - z, -k) * a + std::pow(1 - w, -k) * b;
      CHECK((y - exact).norm() <= tolerance * exact.norm());
    }
    const Statistics s = stepper.statistics();
    CHECK(s.jacobians + s.factorizations == 0);
    CHECK(s.linear_iterations > 0);
    CHECK(s.solves == s.iterations);
    CHECK(s.force_calls == c.calls);
    return s;
  };
  // Rounding: W's condition number is 1 + 8·101²·dt = 83.
  SECTION("products from the force") {
    const Statistics s = run(HeatWithProduct{{m, &c.calls, &c.products}}, 1e-13);
    CHECK(s.force_calls == s.iterations);
    CHECK(c.products >= s.linear_iterations);
  }
  SECTION("preconditioned by W's diagonal") {
    const Statistics s = run(HeatWithDiagonal{{{m, &c.calls, &c.products}}}, 1e-13);
    CHECK(s.force_calls == s.iterations);
  }
  SECTION("products by differences: one force call each") {
    const Statistics s = run(Heat2d{m, &c.calls, &c.products}, 1e-13);
    CHECK(s.force_calls >= s.iterations + s.linear_iterations);
  }
}

TEST_CASE("the Brusselator on 71 x 71 points: differences and automatic differentiation solve the same equations") {
  const Brusselator problem{71};
  const Vec start = problem.start();
  REQUIRE(start.size() == 10082);
  const double dt = 0.05;
  const auto run = [&](auto force) {
    Vec y = start;
    PhiStepper stepper{y, force, backward_euler, newton<MatrixFree<Eigen::BiCGSTAB>>()};
    for (int k = 0; k < 3; ++k) {
      const Vec before = y;
      const StepReport report = stepper.step(y, 0, dt);
      INFO(report.message());
      REQUIRE(report);
      // y⁺ − y = Δt Ψ(y⁺), to what rounding leaves in Ψ: 8α·71²Δt·u·|y| = 80·0.05·u·|y|
      CHECK((y - before - dt * problem(y)).cwiseAbs().maxCoeff() <= 1e-13 * y.cwiseAbs().maxCoeff());
    }
    CHECK(stepper.statistics().jacobians == 0);
    return std::pair{y, stepper.statistics()};
  };
  const auto [by_differences, few] = run([&](const Vec& y) -> Vec { return problem(y); });
  const auto [by_autodiff, many] = run(autodiff(problem));
  CHECK((by_differences - by_autodiff).norm() <= 1e-12 * by_autodiff.norm());
  // A directional derivative is no force call.
  CHECK(many.force_calls == many.iterations);
  CHECK(few.force_calls == few.iterations + 2 * few.linear_iterations);
  Vec y = start;
  CHECK_THROWS_AS((PhiStepper{y, [&](const Vec& x) -> Vec { return problem(x); }, backward_euler}),
                  std::invalid_argument);
}

TEST_CASE("a motion: K and C in one product, terms of a sum with products and with entries") {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Motion<Vec> start{Vec(200), Vec(200)};
  for (auto& x : start.r) x = normal(random);
  for (auto& x : start.v) x = normal(random);
  const Vec masses = Vec::LinSpaced(200, 1, 3);
  const auto run = [&](auto force, auto scheme, auto solver) {
    Motion<Vec> y = start;
    PhiStepper stepper{y, force + LinearDrag{0.3} + Gravity{Eigen::Vector2d(0, -1)}, scheme, mass(masses), solver};
    for (int k = 0; k < 4; ++k) {
      const StepReport report = stepper.step(y, 0, 0.2);
      INFO(report.message());
      REQUIRE(report);
    }
    return y;
  };
  const auto compare = [&](auto scheme) {
    const Motion<Vec> exact = run(term(Chain{}), scheme, newton());
    const auto check = [&](const Motion<Vec>& y) {
      CHECK((y.r - exact.r).norm() <= 1e-13 * exact.r.norm());
      CHECK((y.v - exact.v).norm() <= 1e-13 * exact.v.norm());
    };
    check(run(term(Chain{}), scheme, newton<MatrixFree<Eigen::BiCGSTAB>>()));
    check(run(term(ChainWithProduct{}), scheme, newton<MatrixFree<Eigen::BiCGSTAB>>()));
  };
  compare(trapezoidal);
  compare(midpoint);
  compare(velocity_verlet);
}

TEST_CASE("units: lengths, times and masses scaled by powers of two change no count and no bit") {
  const auto run = [](double length, double time) {
    Motion<Vec> y{Vec::LinSpaced(50, 1, 2) * length, Vec::LinSpaced(50, -1, 1) * length / time};
    const auto force = [=](const Vec& r, const Vec& v) -> Vec {
      Vec f = -(r.array() / length).cube().matrix() * length / (time * time) - 0.1 * v / time;
      f.head(49) += (r.tail(49) - r.head(49)) / (time * time);
      return f;
    };
    PhiStepper stepper{y, force, backward_euler, newton<MatrixFree<Eigen::BiCGSTAB>>()};
    for (int k = 0; k < 3; ++k) REQUIRE(stepper.step(y, 0, 0.25 * time));
    return std::pair{Vec(y.r / length), stepper.statistics()};
  };
  const auto [r, s] = run(1, 1);
  const auto [scaled_r, scaled_s] = run(std::ldexp(1.0, -31), std::ldexp(1.0, -45));  // about 1e-10 m, 1e-14 s
  CHECK((r.array() == scaled_r.array()).all());
  CHECK(s == scaled_s);
}

TEST_CASE("failures of products are named, and nothing moves") {
  Counts c;
  constexpr Index m = 20;
  Vec y = mode(m, 1, 2) + mode(m, 3, 3);
  const Vec start = y;
  SECTION("the wrong sign") {
    PhiStepper stepper{y, HeatWithWrongSign{{m, &c.calls, &c.products}}, backward_euler,
                       newton<MatrixFree<Eigen::GMRES>>()};
    const StepReport report = stepper.step(y, 0, 1e-2);
    CHECK_FALSE(report);
    CAPTURE(report.message());
    CHECK((report.outcome() == Outcome::newton_diverged || report.outcome() == Outcome::newton_stalled ||
           report.outcome() == Outcome::linear_solver_failed));
  }
  SECTION("a product that isn't finite") {
    PhiStepper stepper{y, Nan{{m, &c.calls, &c.products}}, backward_euler, newton<MatrixFree<Eigen::BiCGSTAB>>()};
    CHECK(stepper.step(y, 0, 1e-2).outcome() == Outcome::non_finite_jacobian);
  }
  SECTION("a singular matrix") {
    PhiStepper stepper{y, Null{}, backward_euler, newton<MatrixFree<Eigen::BiCGSTAB>>()};  // W = 1 − 1·1 = 0
    const StepReport report = stepper.step(y, 0, 1.0);
    CAPTURE(report.message());
    CHECK_FALSE(report);
  }
  CHECK((y.array() == start.array()).all());
}

namespace {
/// A preconditioner of the user's own: counts its setups, and divides by what W's diagonal is known to be.
struct Own {
  static inline int setups = 0;
  double inverse = 1;
  Own() = default;
  template <class Operator>
  explicit Own(const Operator& W) {
    compute(W);
  }
  Own& analyzePattern(const auto&) { return *this; }
  Own& factorize(const auto& W) { return compute(W); }
  Own& compute(const auto& W) {
    ++setups;
    inverse = 1 / (1 + W.gamma_force * 4 * 21 * 21);
    return *this;
  }
  [[nodiscard]] Vec solve(const auto& b) const { return inverse * b; }
  [[nodiscard]] static Eigen::ComputationInfo info() { return Eigen::Success; }
};
}  // namespace

TEST_CASE("a preconditioner of one's own, and a tolerance") {
  Counts c;
  constexpr Index m = 20;
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  Vec y(m * m);
  for (auto& x : y) x = normal(random);
  Vec z = y;
  PhiStepper loose{y, HeatWithProduct{{m, &c.calls, &c.products}}, backward_euler,
                   newton<MatrixFree<phistep::ConjugateGradient, Own>>({.rtol = 1e-4, .atol = 1e-6})};
  REQUIRE(loose.step(y, 0, 1e-3));
  CHECK(Own::setups == loose.statistics().iterations);
  PhiStepper tight{z, HeatWithProduct{{m, &c.calls, &c.products}}, backward_euler,
                   newton<MatrixFree<phistep::ConjugateGradient>>()};
  REQUIRE(tight.step(z, 0, 1e-3));
  CHECK(loose.statistics().linear_iterations < tight.statistics().linear_iterations);
  CHECK((y - z).norm() <= 1e-4 * z.norm());
}

namespace {
/// Points that move, heat by drag and cool: r, v and a temperature of another unit and size.
struct Warm {
  Vec r, v, T;
  static constexpr bool drifts = true;
  static auto blocks(auto& y) { return std::tie(y.r, y.v, y.T); }
  struct Rate {
    Vec force, heat;
    static auto blocks(auto& rate) { return std::tie(rate.force, rate.heat); }
  };
};
struct WarmForce {
  static void add(double /*t*/, const Warm& y, Warm::Rate& out) {
    out.force.array() -= 5 * y.r.array() + 1e-3 * y.T.array() * y.v.array();
    out.heat.array() += 10 * y.v.array().square() - 3 * (y.T.array() - 300);
  }
};
struct WarmWithProduct : WarmForce {
  static void apply_jacobian(double /*t*/, const Warm& y, const Warm& x, Warm::Rate& out) {
    out.force.array() -= 5 * x.r.array() + 1e-3 * (x.T.array() * y.v.array() + y.T.array() * x.v.array());
    out.heat.array() += 20 * y.v.array() * x.v.array() - 3 * x.T.array();
  }
};
struct WarmWithEntries : WarmForce {
  static void add_jacobian(double /*t*/, const Warm& y, auto& sink) {
    const Index n = y.r.size();
    for (Index i = 0; i < n; ++i) {
      sink.position(i, i, -5);
      sink.velocity(i, i, -1e-3 * y.T[i]);
      sink.velocity(i, n + i, -1e-3 * y.v[i]);
      sink.velocity(n + i, i, 20 * y.v[i]);
      sink.velocity(n + i, n + i, -3);
    }
  }
};
}  // namespace

TEST_CASE("a state of several blocks and units: products of every kind, and fixed-point iteration, agree with Newton") {
  const auto run = [](auto force, auto solver) {
    Warm y{Vec::LinSpaced(30, -1, 1), Vec::LinSpaced(30, 2, 1), Vec::Constant(30, 310)};
    PhiStepper stepper{y, force, trapezoidal, solver};
    for (int k = 0; k < 5; ++k) {
      const StepReport report = stepper.step(y, 0, 0.1);
      INFO(report.message());
      REQUIRE(report);
    }
    return y;
  };
  const Warm exact = run(WarmForce{}, newton());
  const auto check = [&](const Warm& y) {
    CHECK((y.r - exact.r).norm() <= 1e-13 * exact.r.norm());
    CHECK((y.v - exact.v).norm() <= 1e-13 * exact.v.norm());
    CHECK((y.T - exact.T).norm() <= 1e-13 * exact.T.norm());
  };
  check(run(WarmForce{}, newton<MatrixFree<Eigen::BiCGSTAB>>()));
  check(run(WarmWithProduct{}, newton<MatrixFree<Eigen::BiCGSTAB>>()));
  check(run(WarmWithEntries{}, newton<MatrixFree<Eigen::BiCGSTAB>>()));
  check(run(WarmForce{}, fixed_point()));
  check(run(WarmForce{}, fixed_point({.depth = 0})));
}
