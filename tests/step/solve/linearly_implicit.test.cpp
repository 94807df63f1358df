// One Newton correction a step: what it costs, its order, and that it is content with one.
#include <phistep/phistep.hpp>

#include <cmath>

#include "accuracy/observed_order.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#if PHISTEP_QUICK
#include "support/shared_force.hpp"
#endif
#if PHISTEP_FULL
#include "problems/damped_pendulum.hpp"
#endif

using namespace phistep;

#if PHISTEP_QUICK

using V2 = Eigen::Vector2d;
using OfState = shared_force::OfState<V2>;

namespace {
const OfState pendulum = [](const V2& r) -> V2 { return -r.array().sin(); };
const Motion<V2> from{V2(1, 1), V2(0.3, 0.3)};
}  // namespace

TEST_CASE("linearly implicit: one Jacobian, one factorization, one solve a step, no iteration") {
  Motion<V2> y = from;
  PhiStepper stepper{y, pendulum, backward_euler, linearly_implicit()};
  for (int n = 0; n < 10; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
  const Statistics& s = stepper.statistics();
  CHECK(s.jacobians == 10);
  CHECK(s.factorizations == 10);
  CHECK(s.solves == 10);
  CHECK(s.iterations == 0);
  CHECK(s.force_calls == 10 + 2 * 10);  // two for each Jacobian by differences
}

TEST_CASE("linearly implicit: the scheme's order, with damping too") {
  PhiStepper fine{from, pendulum, rkn86};
  const auto exact = problems::march(fine, from, 0.0, 1.0, 200);
  const auto errors = [&](auto scheme) {
    return convergence::errors(100, [&](int steps) {
      PhiStepper stepper{from, pendulum, scheme, linearly_implicit()};
      return problems::distance(problems::march(stepper, from, 0.0, 1.0, steps), exact);
    });
  };
  convergence::check_order(errors(backward_euler), 1);
  convergence::check_order(errors(trapezoidal), 2);
}

TEST_CASE("linearly implicit: between trapezoidal and backward Euler, each step asks the force itself") {
  // phi > 1/2 carries what its solve knows of the force. After one correction that is a tangent's: carried on, the force
  // was never asked again, and differences were made from what it is not.
  const OfState f = [](const V2& x) -> V2 { return -2 * x - x.cwiseProduct(x); };
  const auto end = [&](int steps, Statistics& work) {
    V2 y(1, 2);
    PhiStepper stepper{y, f, phi(0.7), linearly_implicit()};
    for (int n = 0; n < steps; ++n) problems::step(stepper, y, 1.0 * n / steps, 1.0 / steps);
    work = stepper.statistics();
    return y;
  };
  // y' = -2y - y², 1/y + 1/2 grows by e² in the unit of time.
  const auto exact = [](double y) { return 1 / ((1 / y + 0.5) * std::exp(2.0) - 0.5); };
  const V2 truth(exact(1), exact(2));
  Statistics work;
  const double coarse = (end(50, work) - truth).norm(), fine = (end(100, work) - truth).norm();
  CHECK(coarse / fine > 1.9);
  CHECK(coarse / fine < 2.2);
  CHECK(fine < 5e-3);
  CHECK(work.force_calls == 100 + 2 * 100);
}

TEST_CASE("linearly implicit: stable at any stiffness, and nothing is lost where the matrix is singular") {
  V2 y(1, 1);
  const OfState f = [](const V2& x) -> V2 { return -1e8 * x.array().cube(); };
  PhiStepper stepper{y, f, backward_euler, linearly_implicit()};
  for (int n = 0; n < 50; ++n) {
    const double before = y[0];
    problems::step(stepper, y, 1.0 * n, 1.0);
    // y + h f/(1 − h f') = y (1 − 1/3) for y³ this stiff
    CHECK(y[0] == Approx(before * 2 / 3).epsilon(1e-3));
    if (y[0] < 1e-2) break;
  }
  V2 z(1, 1);
  const V2 kept = z;
  PhiStepper growing{z, OfState([](const V2& x) -> V2 { return x; }), backward_euler, linearly_implicit()};
  CHECK_FALSE(growing.step(z, 0, 1.0));
  CHECK(z == kept);
}

#elif PHISTEP_FULL
// One Newton correction a step, in dynamic vectors and with damping.

using Vec = Eigen::VectorXd;

namespace {

struct Pendulum {
  Vec operator()(const Vec& r) const { return -r.array().sin(); }
  Eigen::MatrixXd jacobian(const Vec& r) const { return (-r.array().cos()).matrix().asDiagonal(); }
};
const Motion<Vec> start{Vec::Constant(2, 1.0), Vec::Constant(2, 0.3)};

}  // namespace

TEST_CASE("linearly implicit: one Jacobian, one factorization, one solve a step, no iteration") {
  Motion<Vec> y = start;
  PhiStepper stepper{y, Pendulum{}, backward_euler, linearly_implicit()};
  for (int n = 0; n < 10; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
  const Statistics& s = stepper.statistics();
  CHECK(s.jacobians == 10);
  CHECK(s.factorizations == 10);
  CHECK(s.solves == 10);
  CHECK(s.iterations == 0);
  CHECK(s.force_calls == 10);
}

TEST_CASE("linearly implicit: the scheme's order, with damping too") {
  using problems::DampedPendulum;
  const auto order = [](const auto& state, const auto& force, auto scheme, double expected) {
    PhiStepper fine{state, force, trapezoidal};
    const auto exact = problems::march(fine, state, 0.0, 1.0, 20000);
    const auto errors = convergence::errors(100, [&](int steps) {
      PhiStepper stepper{state, force, scheme, linearly_implicit()};
      return problems::distance(problems::march(stepper, state, 0.0, 1.0, steps), exact);
    });
    convergence::check_order(errors, expected);
  };
  order(start, Pendulum{}, backward_euler, 1);
  order(start, Pendulum{}, trapezoidal, 2);
  order(start, Pendulum{}, midpoint, 2);
  order(DampedPendulum::start(), DampedPendulum{}, trapezoidal, 2);
}

TEST_CASE("linearly implicit: stable at any stiffness, and nothing is lost where the matrix is singular") {
  Vec y = Vec::Constant(1, 1.0);
  const auto f = [](const Vec& x) -> Vec { return -1e8 * x.array().cube(); };
  PhiStepper stepper{y, f, backward_euler, linearly_implicit()};
  for (int n = 0; n < 50; ++n) {
    const double before = y[0];
    problems::step(stepper, y, 1.0 * n, 1.0);
    // y + h f/(1 − h f') = y (1 − 1/3) for y³ this stiff
    CHECK(y[0] == Approx(before * 2 / 3).epsilon(1e-3));
    if (y[0] < 1e-2) break;
  }
  Vec z = Vec::Constant(1, 1.0);
  const Vec kept = z;
  PhiStepper growing{z, [](const Vec& x) -> Vec { return x; }, backward_euler, linearly_implicit()};
  CHECK_FALSE(growing.step(z, 0, 1.0));
  CHECK(z[0] == kept[0]);
}

#endif
