// One Newton correction a step: what it costs, its order, and that it is content with one.
#include <phistep/phistep.hpp>

#include <cmath>

#include "convergence/observed_order.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;

using V2 = Eigen::Vector2d;
using OfState = shared_force::OfState<V2>;

namespace {
const OfState pendulum = [](const V2& r) -> V2 { return -r.array().sin(); };
const Motion<V2> from{V2(1, 1), V2(0.3, 0.3)};
}  // namespace

TEST_CASE("linearly implicit: one Jacobian, one factorisation, one solve a step, no iteration") {
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
