// One Newton correction a step, in dynamic vectors and with damping; the quick half is linearly_implicit.test.cpp.
#include <phistep/phistep.hpp>

#include <cmath>

#include "convergence/observed_order.hpp"
#include "problems/damped_pendulum.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
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
