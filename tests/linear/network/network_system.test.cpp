// Networks against the dense system with the same entries; clamping, messages, counts.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "support/catch.hpp"
#if PHISTEP_STRESS
#include <Eigen/Dense>
#endif

namespace network_cases {

using namespace phistep;
using Vec = Eigen::VectorXd;

/// A random net: `particles` in a box, each joined to a few others; the last one to none.
template <int dim>
struct Net {
  Motion<Vec> state;
  std::vector<Spring> springs;
  Vec masses;

  explicit Net(int particles, double longest = 0.8, unsigned seed = 5) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    const auto numbers = [&](double from, double to) {
      return Vec::NullaryExpr(dim * particles, [&](Eigen::Index) { return from + (to - from) * uniform(random); })
          .eval();
    };
    state.r = numbers(0, 3);
    state.v = numbers(-1, 1);
    masses = numbers(0.5, 2);
    for (int i = 0; i + 1 < particles; ++i)
      for (int n = 0; n < 4; ++n) {
        const int j = static_cast<int>(uniform(random) * (particles - 1));
        if (i == j) continue;
        const double l = (state.r.template segment<dim>(dim * i) - state.r.template segment<dim>(dim * j)).norm();
        springs.push_back({i, j, 10 + 50 * uniform(random), longest * l * uniform(random)});
      }
  }
  [[nodiscard]] auto each_mass() const {
    return [this](auto&& put) {
      for (Eigen::Index i = 0; i < masses.size(); ++i) put(i, i, masses[i]);
    };
  }
};

template <class V>
struct View {
  const V &r, &v;
};

/// W by the dense system's entries, for solves that must be clamped.
template <int dim>
Eigen::MatrixXd clamped_matrix(const Net<dim>& net, const std::vector<Spring>& springs, double gamma) {
  Eigen::MatrixXd W = net.masses.asDiagonal();
  using Small = Eigen::Matrix<double, dim, dim>;
  for (const Spring& s : springs) {
    const auto i = dim * s.i, j = dim * s.j;
    const Eigen::Matrix<double, dim, 1> d = net.state.r.template segment<dim>(j) - net.state.r.template segment<dim>(i);
    const double length = d.norm();
    const Small along = d * d.transpose() / (length * length);
    const Small B = gamma * s.stiffness * (along + std::max(0.0, 1 - s.length / length) * (Small::Identity() - along));
    W.template block<dim, dim>(i, i) += B;
    W.template block<dim, dim>(j, j) += B;
    W.template block<dim, dim>(i, j) -= B;
    W.template block<dim, dim>(j, i) -= B;
  }
  return W;
}

/// B = along nnᵀ + across (I − nnᵀ) with along < across, as pair forces have near the bottom of their potential.
struct Softening {
  const Net<3>& net;
  void operator()(const auto& y, auto& sink) const {
    for (const Spring& s : net.springs) {
      const Eigen::Vector3d n = (y.r.template segment<3>(3 * s.j) - y.r.template segment<3>(3 * s.i)).normalized();
      const double along = 0.1 * s.stiffness, across = 0.3 * s.stiffness;
      if constexpr (requires { sink.edge(s.i, s.j, n.data(), PairTangent<double>{}); }) {
        sink.edge(s.i, s.j, n.data(), {along, across});
      } else {
        const Eigen::Matrix3d B = across * Eigen::Matrix3d::Identity() + (along - across) * n * n.transpose();
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) {
            sink.position(3 * s.i + a, 3 * s.j + b, B(a, b));
            sink.position(3 * s.j + a, 3 * s.i + b, B(a, b));
            sink.position(3 * s.i + a, 3 * s.i + b, -B(a, b));
            sink.position(3 * s.j + a, 3 * s.j + b, -B(a, b));
          }
      }
    }
  }
};

void check_linear_net(auto scheme) {
  Net<3> net(40);
  for (Spring& s : net.springs) s.length = 0;  // f = k d: linear
  auto y = net.state;
  PhiStepper stepper{y, spring_network<3>(net.springs), scheme, mass(net.masses), newton({.linear_rtol = 1e-12})};
  REQUIRE(stepper.step(y, 0, 0.1));
  const Statistics first = stepper.statistics();
  CHECK(first.jacobians == 1);
  CHECK(first.analyses == 1);
  CHECK(first.factorizations == 1);
  CHECK(first.solves == first.iterations);
  CHECK(first.force_calls == first.iterations);
  CHECK(first.linear_iterations > 0);
  CHECK(first.fallbacks == 0);
  REQUIRE(stepper.step(y, 0.1, 0.1));
  CHECK(stepper.statistics().factorizations == 1);
  REQUIRE(stepper.step(y, 0.2, 0.05));
  CHECK(stepper.statistics().factorizations == 2);
  CHECK(stepper.statistics().jacobians == 1);
}

/// Of two factorizations and solves of one pattern.
inline void check_counts(const Statistics& counts) {
  CHECK(counts.analyses == 1);
  CHECK(counts.factorizations == 2);
  CHECK(counts.linear_iterations > 0);
  CHECK(counts.fallbacks == 0);
}

}  // namespace network_cases

using namespace network_cases;

#if PHISTEP_FULL

namespace {

/// K and C entry by entry.
struct Entries {
  Eigen::MatrixXd K, C;
  void position(Eigen::Index i, Eigen::Index j, double x) { K(i, j) += x; }
  void velocity(Eigen::Index i, Eigen::Index j, double x) { C(i, j) += x; }
};
void check_residual(const Entries& A, const Vec& masses, double gamma_force, double gamma_drift, const Vec& x,
                    const Vec& b) {
  const Eigen::Index n = b.size();
  double worst = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    double sum = masses[i] * x[i] - b[i];
    for (Eigen::Index j = 0; j < n; ++j) sum -= gamma_force * (A.C(i, j) + gamma_drift * A.K(i, j)) * x[j];
    worst += sum * sum;
  }
  CHECK(std::sqrt(worst) <= 1e-12 * b.norm());
}

/// Solves with edges, and looks at what the same force's entries make of it.
template <int dim, bool has_C>
void check_against_dense(auto&& force, const Net<dim>& net, double gamma_force, double gamma_drift,
                         Statistics& counts) {
  const Eigen::Index n = net.state.r.size();
  NetworkSystem<double, dim, true, has_C> edges;
  edges.resize(n);
  Entries entries{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n)};
  const View<Vec> view{net.state.r, net.state.v};
  force(view, entries);
  const Vec b = Vec::LinSpaced(n, -1, 2);
  for (int again = 0; again < 2; ++again) {  // the second time the pattern is known
    edges.clear();
    force(view, edges);
    REQUIRE(edges.is_finite());
    REQUIRE(edges.factorize(net.each_mass(), gamma_force, gamma_drift, counts) == Outcome::success);
    Vec x = b;
    REQUIRE(edges.solve(x, 1e-13, counts) == Outcome::success);
    check_residual(entries, net.masses, gamma_force, gamma_drift, x, b);
  }
  check_counts(counts);
}

}  // namespace

TEST_CASE("solves what dense LU solves") {
  const Net<3> net(23);
  Net<2> still(23);
  still.state.v.setZero();
  Statistics counts, others;
  check_against_dense<3, false>(
      [&](const auto& y, auto& sink) { spring_network<3>(net.springs).add_jacobian(0.0, y, sink); }, net, 0.3, 0.2,
      counts);
  // Dashpots, whose geometric part is left out: at rest there is none; drag and a local block beside them.
  check_against_dense<2, true>(
      [&](const auto& y, auto& sink) {
        spring_network<2>(still.springs, SpringDamping{2.5}).add_jacobian(0.0, y, sink);
        LinearDrag{0.7}.add_jacobian(0.0, y, sink);
        sink.position(0, 1, -3.0);  // a coupling within particle 0, symmetric
        sink.position(1, 0, -3.0);
        for (int a = 0; a < 2; ++a) sink.position(a, a, -8.0);
      },
      still, 0.3, 0.2, others);
}

TEST_CASE("a pair that softens along its direction") {
  const Net<3> net(23);
  Statistics counts;
  check_against_dense<3, false>(Softening{net}, net, 0.3, 0.2, counts);
}

TEST_CASE("an indefinite tangent is clamped, once and counted") {
  const Net<3> net(30, 3.0);  // springs up to three times too short for their length at rest: most are compressed
  const auto network = spring_network<3>(net.springs);
  NetworkSystem<double, 3, true, false> system;
  system.resize(90);
  Statistics counts;
  network.add_jacobian(0.0, View<Vec>{net.state.r, net.state.v}, system);
  REQUIRE(system.factorize(net.each_mass(), 1.0, 1.0, counts) == Outcome::success);
  const Vec b = Vec::LinSpaced(90, -1, 2);
  Vec x = b;
  REQUIRE(system.solve(x, 1e-13, counts) == Outcome::success);
  CHECK(counts.fallbacks == 1);
  const Eigen::MatrixXd W = clamped_matrix(net, net.springs, 1.0);
  CHECK((W * x - b).norm() <= 1e-11 * b.norm());
  x = b;
  REQUIRE(system.solve(x, 1e-13, counts) == Outcome::success);
  CHECK(counts.fallbacks == 1);  // the same factors serve again
  // A smaller step is definite again and starts from the exact tangent.
  REQUIRE(system.factorize(net.each_mass(), 1e-2, 1e-2, counts) == Outcome::success);
  REQUIRE(system.solve(x, 1e-13, counts) == Outcome::success);
  CHECK(counts.fallbacks == 1);
}

TEST_CASE("a local force that makes a particle's own block indefinite is left out where clamped") {
  NetworkSystem<double, 2, true, false> system;
  system.resize(4);
  Statistics counts;
  const double n[] = {1, 0};
  system.edge(0, 1, n, {1, 1});
  system.position(0, 0, 50.0);  // pushes particle 0 away: W(0, 0) = 1 + 1 − 50
  const auto masses = [](auto&& put) {
    for (int i = 0; i < 4; ++i) put(i, i, 1.0);
  };
  REQUIRE(system.factorize(masses, 1.0, 1.0, counts) == Outcome::success);
  CHECK(counts.fallbacks == 1);
  Vec x{{3, 0, 3, 0}};
  REQUIRE(system.solve(x, 1e-14, counts) == Outcome::success);
  CHECK((x - Vec{{3, 0, 3, 0}}).norm() <= 1e-13);  // both move alike: the spring is idle, masses are 1
}

TEST_CASE("springs without length, nets without springs, particles without a pair, unknowns that fill no particle") {
  NetworkSystem<double, 3, true, false> system;
  system.resize(8);  // two particles and two numbers more
  Statistics counts;
  const auto masses = [](auto&& put) {
    for (int i = 0; i < 8; ++i) put(i, i, 2.0);
  };
  REQUIRE(system.is_finite());
  REQUIRE(system.factorize(masses, 1.0, 1.0, counts) == Outcome::success);
  Vec x = Vec::Ones(8);
  REQUIRE(system.solve(x, 1e-14, counts) == Outcome::success);
  CHECK(x == Vec::Constant(8, 0.5));

  Vec r = Vec::Zero(8);
  const View<Vec> view{r, r};
  system.clear();
  spring_network<3>({{0, 1, 7.0, 1.0}}).add_jacobian(0.0, view, system);  // no direction: no tangent
  REQUIRE(system.is_finite());
  REQUIRE(system.factorize(masses, 1.0, 1.0, counts) == Outcome::success);
  x.setOnes();
  REQUIRE(system.solve(x, 1e-14, counts) == Outcome::success);
  CHECK(x == Vec::Constant(8, 0.5));

  system.clear();
  spring_network<3>({{0, 1, 7.0, 0.0}}).add_jacobian(0.0, view, system);  // L = 0: k d, smooth everywhere
  REQUIRE(system.factorize(masses, 1.0, 1.0, counts) == Outcome::success);
  x.setZero();
  x[0] = 16;
  REQUIRE(system.solve(x, 1e-15, counts) == Outcome::success);
  CHECK(x[0] == Approx(16 * 9 / 32.0).epsilon(1e-14));  // [9 −7; −7 9]⁻¹ = [9 7; 7 9]/32
  CHECK(x[3] == Approx(16 * 7 / 32.0).epsilon(1e-14));
  CHECK(x[6] == 0);

  CHECK(NetworkSystem<double, 3, true, false>{}.is_finite());
}

TEST_CASE("what is no pair, and what couples two particles in a network's local part, is refused") {
  NetworkSystem<double, 3, true, true> system;
  system.resize(9);
  const double n[] = {1, 0, 0};
  CHECK_THROWS_WITH(system.edge(0, 3, n, {1, 1}), contains("no pair of particles: 0 and 3 of 3"));
  CHECK_THROWS_AS(system.edge(-1, 0, n, {1, 1}), std::invalid_argument);
  CHECK_THROWS_AS(system.edge(2, 2, n, {1, 1}), std::invalid_argument);
  CHECK_THROWS_WITH(system.position(2, 3, 1.0), contains("between particles 0 and 1"));
  CHECK_THROWS_AS(system.velocity(8, 0, 1.0), std::invalid_argument);
}

TEST_CASE("a pattern that changes is made anew") {
  NetworkSystem<double, 1, true, false> system;
  system.resize(4);
  Statistics counts;
  const auto masses = [](auto&& put) {
    for (int i = 0; i < 4; ++i) put(i, i, 1.0);
  };
  const double n[] = {1};
  const auto solve = [&](const std::vector<std::pair<int, int>>& pairs) {
    system.clear();
    for (const auto& [i, j] : pairs) system.edge(i, j, n, {1, 1});
    REQUIRE(system.factorize(masses, 1.0, 1.0, counts) == Outcome::success);
    Vec x{{8, 0, 0, 0}};
    REQUIRE(system.solve(x, 1e-14, counts) == Outcome::success);
    return x;
  };
  const Vec chain = solve({{0, 1}, {1, 2}, {2, 3}});
  CHECK(counts.analyses == 1);
  CHECK(chain.sum() == Approx(8));
  CHECK(solve({{0, 1}, {1, 2}, {2, 3}}) == chain);
  CHECK(counts.analyses == 1);
  CHECK((solve({{1, 0}, {2, 3}, {1, 2}}) - chain).norm() <= 1e-13);  // another order, the same net
  CHECK(counts.analyses == 2);
  CHECK((solve({{0, 1}}) - Vec{{16.0 / 3, 8.0 / 3, 0, 0}}).norm() <= 1e-13);
  CHECK(counts.analyses == 3);
  CHECK((solve({{0, 1}, {1, 2}, {2, 3}}) - chain).norm() <= 1e-13);
  CHECK(counts.analyses == 4);
  CHECK((solve({{0, 1}}) - Vec{{16.0 / 3, 8.0 / 3, 0, 0}}).norm() <= 1e-13);  // the same pairs as before, but fewer
  CHECK(counts.analyses == 5);
}

TEST_CASE("finds a tangent that is not finite") {
  NetworkSystem<double, 2, true, true> system;
  system.resize(4);
  const double n[] = {1, 0}, bad[] = {0, HUGE_VAL};
  const auto is_finite = [&](auto&& fill) {
    system.clear();
    fill();
    return system.is_finite();
  };
  CHECK(is_finite([&] { system.edge(0, 1, n, {1, 1}, {1, 1}); }));
  CHECK_FALSE(is_finite([&] { system.edge(0, 1, bad, {1, 1}, {1, 1}); }));
  CHECK_FALSE(is_finite([&] { system.edge(0, 1, n, {1, std::nan("")}, {1, 1}); }));
  CHECK_FALSE(is_finite([&] { system.edge(0, 1, n, {1, 1}, {-HUGE_VAL, 1}); }));
  CHECK_FALSE(is_finite([&] { system.velocity(3, 3, std::nan("")); }));
  CHECK(is_finite([&] { system.edge(0, 1, n, {1, 1}, {1, 1}); }));
}

TEST_CASE("a net in a random numbering gives the same motion, and the same bits every time") {
  const Net<3> net(60);
  const auto run = [&] {
    auto y = net.state;
    PhiStepper stepper{y, spring_network<3>(net.springs), phi_stage(0.5), mass(net.masses),
                       newton({.linear_rtol = 1e-12})};
    for (int n = 0; n < 5; ++n) REQUIRE(stepper.step(y, 0, 0.2));
    CHECK(std::string(stepper.solver_name()) == "block-Jacobi conjugate gradients on the edge operator");
    return y;
  };
  const auto y = run(), again = run();
  CHECK(y.r == again.r);
  CHECK(y.v == again.v);
}

TEST_CASE("exact counts: a linear net is one Jacobian, one analysis, and one factorization a step length") {
  check_linear_net(phi_stage(1.0));
}

#elif PHISTEP_STRESS
// network_system: every dimension and kind of tangent, and whole runs.

namespace {

/// Solves with edges and with the dense system's LU, and compares.
template <int dim, bool has_C>
void check_against_dense(auto&& force, const Net<dim>& net, double gamma_force, double gamma_drift,
                         Statistics& counts) {
  const Eigen::Index n = net.state.r.size();
  NetworkSystem<double, dim, true, has_C> edges;
  DenseSystem<double, Eigen::Dynamic, true, has_C> dense;
  edges.resize(n);
  dense.resize(n);
  Statistics others;
  const View<Vec> view{net.state.r, net.state.v};
  const Vec b = Vec::LinSpaced(n, -1, 2);
  for (int again = 0; again < 2; ++again) {  // the second time the pattern is known
    edges.clear();
    dense.clear();
    force(view, edges);
    force(view, dense);
    REQUIRE(edges.is_finite());
    REQUIRE(edges.factorize(net.each_mass(), gamma_force, gamma_drift, counts) == Outcome::success);
    REQUIRE(dense.factorize(net.each_mass(), gamma_force, gamma_drift, others) == Outcome::success);
    Vec x = b, y = b;
    REQUIRE(edges.solve(x, 1e-13, counts) == Outcome::success);
    REQUIRE(dense.solve(y) == Outcome::success);
    // Relative residual 1e-13, times the condition number, which is below 200 for these nets.
    CHECK((x - y).norm() <= 2e-11 * y.norm());
  }
  check_counts(counts);
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("solves what dense LU solves", "", ((int dim), dim), 1, 2, 3) {
  const Net<dim> net(23);
  SECTION("springs") {
    Statistics counts;
    check_against_dense<dim, false>(
        [&](const auto& y, auto& sink) { spring_network<dim>(net.springs).add_jacobian(0.0, y, sink); }, net, 0.3, 0.2,
        counts);
  }
  SECTION("compressed springs of a step short enough to stay definite") {
    Net<dim> compressed(23, 1.5);
    Statistics counts;
    check_against_dense<dim, false>(
        [&](const auto& y, auto& sink) { spring_network<dim>(compressed.springs).add_jacobian(0.0, y, sink); },
        compressed, 0.03, 0.03, counts);
  }
  SECTION("dashpots, whose geometric part is left out: at rest there is none; drag and a local block beside them") {
    Net<dim> still = net;
    still.state.v.setZero();
    Statistics counts;
    check_against_dense<dim, true>(
        [&](const auto& y, auto& sink) {
          spring_network<dim>(net.springs, SpringDamping{2.5}).add_jacobian(0.0, y, sink);
          LinearDrag{0.7}.add_jacobian(0.0, y, sink);
          sink.position(0, dim - 1, -3.0);  // a coupling within particle 0, symmetric
          sink.position(dim - 1, 0, -3.0);
          for (int a = 0; a < dim; ++a) sink.position(a, a, -8.0);
        },
        still, 0.3, 0.2, counts);
  }
}

TEST_CASE("a net in a random numbering gives the same motion, and the same bits every time") {
  const Net<3> net(60);
  const auto run = [&](const std::vector<Spring>& springs, Motion<Vec> y, const Vec& m) {
    PhiStepper stepper{y, spring_network<3>(springs), midpoint, mass(m)};
    for (int n = 0; n < 5; ++n) REQUIRE(stepper.step(y, 0, 0.2));
    CHECK(std::string(stepper.solver_name()) == "block-Jacobi conjugate gradients on the edge operator");
    return y;
  };
  const auto y = run(net.springs, net.state, net.masses), again = run(net.springs, net.state, net.masses);
  CHECK(y.r == again.r);
  CHECK(y.v == again.v);

  std::vector<int> number(60);
  for (int i = 0; i < 60; ++i) number[static_cast<std::size_t>(i)] = (i * 37 + 11) % 60;
  Net<3> other = net;
  for (Spring& s : other.springs)
    s.i = number[static_cast<std::size_t>(s.i)], s.j = number[static_cast<std::size_t>(s.j)];
  const auto renumber = [&](const Vec& from) {
    Vec to = from;
    for (int i = 0; i < 60; ++i) to.segment<3>(3 * number[static_cast<std::size_t>(i)]) = from.segment<3>(3 * i);
    return to;
  };
  std::reverse(other.springs.begin(), other.springs.end());
  const auto z = run(other.springs, {renumber(net.state.r), renumber(net.state.v)}, renumber(net.masses));
  // Newton ends at rounding: a few ulps of positions up to 5, divided by Δt for v, five steps long.
  CHECK((z.r - renumber(y.r)).norm() <= 1e-12 * y.r.norm());
  CHECK((z.v - renumber(y.v)).norm() <= 1e-12 * (y.v.norm() + y.r.norm() / 0.2));
}

TEST_CASE("exact counts: a linear net is one Jacobian, one analysis, and one factorization a step length") {
  check_linear_net(backward_euler);
}

TEST_CASE("a pair that softens along its direction") {
  const Net<3> net(23);
  Statistics counts;
  check_against_dense<3, false>(Softening{net}, net, 0.3, 0.2, counts);
}

#endif
