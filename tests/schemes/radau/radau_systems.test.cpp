// Radau IIA over every kind of system: the same steps as over a dense one, orders, motion, checkpoints, failures. Other
// systems: radau_systems.stress.
#include <phistep/schemes/radau/radau.hpp>
#include <phistep/sparse.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "contract/restart_run.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#if PHISTEP_STRESS
#include "problems/spring_net.hpp"
#endif

namespace radau_systems_cases {

using namespace phistep;
using problems::distance;
using Vec = Eigen::VectorXd;

/// A chain of n: y_i' = D (y_{i−1} − 2y_i + y_{i+1}) − y_i³ + sin t, zero beyond the ends.
template <Structure of>
struct Chain : ForceTerm {
  static constexpr Structure structure = of;
  static constexpr int block = 2;
  double D;
  explicit Chain(double diffusion = 40) : D{diffusion} {}
  static Vec start(int n = 12) { return Vec::LinSpaced(n, 1, -0.5); }
  void add(auto t, const auto& state, auto& out) const {
    const auto& y = state.y;
    const auto n = y.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      const double left = i > 0 ? y[i - 1] : 0, right = i + 1 < n ? y[i + 1] : 0;
      out.rate[i] += D * (left - 2 * y[i] + right) - y[i] * y[i] * y[i] + std::sin(t);
    }
  }
  void add_jacobian(auto /*t*/, const auto& state, auto& sink) const {
    const auto n = state.y.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      sink.rate(i, i, -2 * D - 3 * state.y[i] * state.y[i]);
      if (i > 0) sink.rate(i, i - 1, D);
      if (i + 1 < n) sink.rate(i, i + 1, D);
    }
  }
};
/// The same as a lambda, for differences.
inline const auto chain = [](const Vec& y, double t) -> Vec {
  Vec out = Vec::Zero(y.size());
  struct View {
    const Vec& y;
  };
  struct Rate {
    Vec& rate;
  } to{out};
  Chain<Structure::dense>{}.add(t, View{y}, to);
  return out;
};

/// Beads on a line with neighbours, r'' = −∂V/∂r − v/5: a motion whose tangents are bands.
template <Structure of>
struct Beads : ForceTerm {
  static constexpr Structure structure = of;
  static constexpr int block = 2;
  static Motion<Vec> start(int n = 10) { return {Vec::LinSpaced(n, 0.3, -0.2), Vec::Zero(n)}; }
  void add(auto /*t*/, const auto& state, auto& out) const {
    const auto& r = state.r;
    const auto n = r.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      const double left = i > 0 ? r[i - 1] : 0, right = i + 1 < n ? r[i + 1] : 0;
      out.force[i] += 30 * (left - 2 * r[i] + right) - 4 * r[i] * r[i] * r[i] - 0.2 * state.v[i];
    }
  }
  void add_jacobian(auto /*t*/, const auto& state, auto& sink) const {
    const auto n = state.r.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      sink.position(i, i, -60 - 12 * state.r[i] * state.r[i]);
      sink.velocity(i, i, -0.2);
      if (i > 0) sink.position(i, i - 1, 30);
      if (i + 1 < n) sink.position(i, i + 1, 30);
    }
  }
};

/// y' = λy
struct Grow : ForceTerm {
  double lambda;
  explicit Grow(double l) : lambda{l} {}
  void add(auto, const auto& state, auto& out) const { out.rate += lambda * state.y; }
  void add_jacobian(auto, const auto& state, auto& sink) const {
    for (Eigen::Index i = 0; i < state.y.size(); ++i) sink.rate(i, i, lambda);
  }
};
struct Band : Grow {
  static constexpr Structure structure = Structure::banded;
  using Grow::Grow;
};
struct Net : Grow {
  static constexpr Structure structure = Structure::sparse;
  using Grow::Grow;
};

struct Ended {
  Vec y;
  Statistics counts;
};
template <class State>
Ended controlled(State y, auto force, double rtol, auto... options) {
  PhiStepper stepper{y, force, radau, options...};
  const RunReport report = integrate(stepper, y, {0, 2}, tolerance{.rtol = rtol, .atol = 1e-3 * rtol});
  INFO(report.message());
  REQUIRE(report);
  Vec end;
  if constexpr (requires { y.r; }) {
    end.resize(2 * y.r.size());
    end << y.r, y.v;
  } else {
    end = y;
  }
  return {end, report.statistics};
}
inline void check_same(const Ended& a, const Ended& b) {
  CHECK((a.y - b.y).lpNorm<Eigen::Infinity>() <= 1e-12);
  CHECK(a.counts.steps == b.counts.steps);
  CHECK(a.counts.iterations == b.counts.iterations);
  CHECK(a.counts.jacobians == b.counts.jacobians);
  CHECK(a.counts.factorizations == b.counts.factorizations);
  CHECK(a.counts.force_calls == b.counts.force_calls);
}
/// The order of convergence, from errors of `least` and twice as many steps.
void check_order(auto force, auto start, int stages, int least, double expected) {
  const auto run = [&](int n) {
    PhiStepper stepper{start, force, radau(stages)};
    const auto y = problems::march(stepper, start, 0.0, 1.0, n);
    if constexpr (requires { y.r; }) return y.r;
    else return y;
  };
  const Vec reference = run(16 * least);
  const double coarse = distance(run(least), reference), fine = distance(run(2 * least), reference);
  CAPTURE(stages, coarse, fine);
  CHECK(std::abs(std::log2(coarse / fine) - expected) <= 0.8);
}
/// A run whose Jacobian is found by differences over a declared pattern: that of the dense one, three colours a Jacobian.
void check_close(auto force, const Ended& dense) {
  const Ended run = controlled(Chain<Structure::dense>::start(), force, 1e-8);
  CHECK((run.y - dense.y).lpNorm<Eigen::Infinity>() <= 1e-7);
  CHECK(run.counts.force_calls >= 4 * run.counts.jacobians);
  CHECK(run.counts.steps <= dense.counts.steps + 2);
}
inline Eigen::SparseMatrix<double> tridiagonal() {
  Eigen::SparseMatrix<double> pattern(12, 12);
  for (int i = 0; i < 12; ++i)
    for (int j = std::max(0, i - 1); j < std::min(12, i + 2); ++j) pattern.insert(i, j) = 1;
  return pattern;
}

}  // namespace radau_systems_cases

using namespace radau_systems_cases;

#if PHISTEP_FULL

namespace {

/// Particles in the plane, each held by its own spring and slowed by v².
struct Anchored : ForceTerm {
  static constexpr Structure structure = Structure::local;
  static constexpr int block = 2;
  void add(auto /*t*/, const auto& state, auto& out) const {
    for (Eigen::Index i = 0; i < state.r.size(); ++i) {
      const double r = state.r.data()[i], v = state.v.data()[i];
      out.force.data()[i] += -100 * r - v * std::abs(v);
    }
  }
  void add_jacobian(auto /*t*/, const auto& state, auto& sink) const {
    for (Eigen::Index i = 0; i < state.r.size(); ++i) {
      sink.position(i, i, -100);
      sink.velocity(i, i, -2 * std::abs(state.v.data()[i]));
    }
  }
};

}  // namespace

TEST_CASE("a band, a sparse matrix: the steps of a dense one, to rounding") {
  for (const double rtol : {1e-3, 1e-6, 1e-9}) {
    CAPTURE(rtol);
    const Ended dense = controlled(Chain<Structure::dense>::start(), Chain<Structure::dense>{}, rtol);
    check_same(controlled(Chain<Structure::banded>::start(), Chain<Structure::banded>{}, rtol), dense);
    const Ended sparse = controlled(Chain<Structure::sparse>::start(), Chain<Structure::sparse>{}, rtol);
    check_same(sparse, dense);
    CHECK(sparse.counts.analyses == 1);
  }
}

TEST_CASE("patterns that are declared: differences by colours, the same answer") {
  const Ended dense = controlled(Chain<Structure::dense>::start(), Chain<Structure::dense>{}, 1e-8);
  check_close(banded(chain, 1, 1), dense);
  check_close(sparsity(chain, tridiagonal()), dense);
}

TEST_CASE("motions: bands, chains, sparse matrices, networks of springs") {
  for (const double rtol : {1e-4, 1e-8}) {
    CAPTURE(rtol);
    const Ended dense = controlled(Beads<Structure::dense>::start(), Beads<Structure::dense>{}, rtol);
    check_same(controlled(Beads<Structure::banded>::start(), Beads<Structure::banded>{}, rtol), dense);
  }
}

TEST_CASE("orders 5 and 9 over every system") {
  // D = 1: little of it is stiff.
  const auto all = [&](int stages, int least, double expected) {
    check_order(Chain<Structure::banded>(1), Chain<Structure::banded>::start(), stages, least, expected);
    check_order(Chain<Structure::sparse>(1), Chain<Structure::banded>::start(), stages, least, expected);
  };
  all(3, 4, 5);
  all(5, 1, 9);
  check_order(Beads<Structure::banded>{}, Beads<Structure::banded>::start(), 3, 20, 5);
}

TEST_CASE("local blocks, many of them") {
  using Columns = Eigen::Matrix2Xd;
  Motion<Columns> y{Columns::Random(2, 400), Columns::Zero(2, 400)};
  auto other = y;
  PhiStepper alone{y, Anchored{}, radau};
  PhiStepper reference{other, Anchored{}, tsit5};
  const RunReport report = integrate(alone, y, {0, 1}, tolerance{.rtol = 1e-8});
  REQUIRE(report);
  CHECK(report.statistics.jacobians < 100);
  REQUIRE(integrate(reference, other, {0, 1}, tolerance{.rtol = 1e-10}));
  CHECK((y.r - other.r).cwiseAbs().maxCoeff() <= 1e-6);
}

TEST_CASE("a failure leaves the state, and the next step is as if it had not been") {
  double poison = 0;
  const auto f = banded([&poison](const Vec& y) -> Vec { return -y + Vec::Constant(y.size(), poison); }, 0, 0);
  Vec y = Vec::Ones(5);
  PhiStepper stepper{y, f, radau(3)};
  poison = std::numeric_limits<double>::quiet_NaN();
  CHECK(stepper.step(y, 0, 0.1).outcome() == Outcome::non_finite_force);
  CHECK(y == Vec::Ones(5));
  poison = 0;
  problems::step(stepper, y, 0.0, 0.1);
  CHECK((y.array() - std::exp(-0.1)).abs().maxCoeff() <= 1e-9);
  // 1/λ₀ h J = 1: the real matrix is singular, as a band; sparse: radau_systems.stress.
  const double growth = radau_constants<double, 3>.lambda.re[0];
  Vec x = Vec::Ones(3);
  CHECK(PhiStepper{x, Band{growth}, radau(3)}.step(x, 0, 1).outcome() == Outcome::singular_matrix);
  CHECK(x == Vec::Ones(3));
}

TEST_CASE("checkpoints: the run that saved and the one that resumes agree bit for bit") {
  const tolerance control{.rtol = 1e-7, .atol = 1e-9};
  const auto nobody = [](auto&) { return std::tuple<>{}; };
  const auto start = [] { return Chain<Structure::sparse>::start(); };
  restart_run::check(start, restart_run::steps(Chain<Structure::sparse>{}, radau), 2, control, nobody);
  restart_run::check(start, restart_run::steps(banded(chain, 1, 1), radau), 2, control, nobody);  // its J is kept
}

#elif PHISTEP_STRESS
// Radau IIA over every kind of system: those that radau_systems.test leaves out.

TEST_CASE("a band, a sparse matrix: the steps of a dense one, to rounding") {
  for (const double rtol : {1e-3, 1e-6, 1e-9}) {
    CAPTURE(rtol);
    check_same(controlled(Chain<Structure::sparse>::start(), symmetric(Chain<Structure::sparse>{}), rtol),
               controlled(Chain<Structure::dense>::start(), Chain<Structure::dense>{}, rtol));
  }
}

TEST_CASE("patterns that are declared: differences by colours, the same answer") {
  const Ended dense = controlled(Chain<Structure::dense>::start(), Chain<Structure::dense>{}, 1e-8);
  check_close(symmetric(sparsity(chain, tridiagonal())), dense);
}

TEST_CASE("motions: bands, chains, sparse matrices, networks of springs") {
  for (const double rtol : {1e-4, 1e-8}) {
    CAPTURE(rtol);
    const Ended dense = controlled(Beads<Structure::dense>::start(), Beads<Structure::dense>{}, rtol);
    check_same(controlled(Beads<Structure::sparse>::start(), Beads<Structure::sparse>{}, rtol), dense);
    check_same(controlled(Beads<Structure::sparse>::start(), symmetric(Beads<Structure::sparse>{}), rtol), dense);
  }
  using problems::SpringNet;
  const Ended springs = controlled(SpringNet::start(), SpringNet::damped(), 1e-8, mass(SpringNet::masses()));
  const auto by_hand = [](const Vec& r, const Vec& v) -> Vec {
    Vec f = Vec::Zero(r.size());
    for (const Spring& s : SpringNet::springs()) {
      const Eigen::Vector2d d = r.segment<2>(2 * s.j) - r.segment<2>(2 * s.i), n = d.normalized();
      const Eigen::Vector2d u = v.segment<2>(2 * s.j) - v.segment<2>(2 * s.i);
      const Eigen::Vector2d pull = (s.stiffness * (d.norm() - s.length) + 0.3 * n.dot(u)) * n;
      f.segment<2>(2 * s.i) += pull;
      f.segment<2>(2 * s.j) -= pull;
    }
    return f;
  };
  Motion<Vec> y = SpringNet::start();
  PhiStepper reference{y, by_hand, tsit5, mass(SpringNet::masses())};
  REQUIRE(integrate(reference, y, {0, 2}, tolerance{.rtol = 1e-10}));
  Vec exact(2 * y.r.size());
  exact << y.r, y.v;
  CHECK((springs.y - exact).lpNorm<Eigen::Infinity>() <= 1e-6);
  CHECK(springs.counts.linear_iterations == 0);
  CHECK(springs.counts.analyses == 1);
}

TEST_CASE("orders 5 and 9 over every system") {
  check_order(Beads<Structure::sparse>{}, Beads<Structure::banded>::start(), 3, 20, 5);
}

TEST_CASE("a failure leaves the state, and the next step is as if it had not been") {
  // 1/λ₀ h J = 1: the real matrix is singular, sparse.
  const double growth = radau_constants<double, 3>.lambda.re[0];
  Vec x = Vec::Ones(3);
  CHECK(PhiStepper{x, Net{growth}, radau(3)}.step(x, 0, 1).outcome() == Outcome::singular_matrix);
  CHECK(x == Vec::Ones(3));
}

TEST_CASE("checkpoints: the run that saved and the one that resumes agree bit for bit") {
  restart_run::check([] { return Beads<Structure::banded>::start(); },
                     restart_run::steps(Beads<Structure::banded>{}, radau), 2, tolerance{.rtol = 1e-7, .atol = 1e-9},
                     [](auto&) { return std::tuple<>{}; });
}

#endif
