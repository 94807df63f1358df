// Radau IIA over every kind of system: the same steps as over a dense one, orders, motion, checkpoints, failures. Other
// systems: radau_systems.full.
#include "schemes/radau/radau_systems_cases.hpp"

#include <limits>
#include <tuple>

using namespace radau_systems_cases;

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
  // 1/λ₀ h J = 1: the real matrix is singular, as a band; sparse: radau_systems.full.
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
