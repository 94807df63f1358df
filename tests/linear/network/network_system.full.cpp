// network_system: every dimension and kind of tangent, and whole runs. The quick half is network_system.test.cpp.
#include <Eigen/Dense>

#include "linear/network/network_system_cases.hpp"

using namespace network_cases;

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
