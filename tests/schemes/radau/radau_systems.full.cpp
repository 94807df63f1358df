// Radau IIA over every kind of system: those that radau_systems.test leaves out.
#include "schemes/radau/radau_systems_cases.hpp"

#include <tuple>

#include "problems/spring_net.hpp"

using namespace radau_systems_cases;

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
