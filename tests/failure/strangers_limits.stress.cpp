// Programs as users write them that come to a limit of a scheme: many steps on a differential-algebraic equation, velocities
// that grow in a magnetic field.
#include <phistep/phistep.hpp>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;

namespace {

using Two = Eigen::Vector2d;
using Four = Eigen::Vector4d;

// ---- a differential-algebraic equation ----

constexpr double period = 6.283185307179586;
/// x' = z, y' = w, 0 = x − y − w, 0 = −x − y − 0.001 z + sin t, from 0.
struct Dae {
  RunReport report;
  Four y = Four::Zero();
};
Dae solve_dae(auto scheme, double rtol) {
  Dae run{};
  const shared_force::OfStateAndTime<Four> rate{[](const Four& u, double t) -> Four {
    return {u[2], u[3], u[0] - u[1] - u[3], -u[0] - u[1] - 1e-3 * u[2] + std::sin(t)};
  }};
  PhiStepper stepper{run.y, rate, scheme, capacity(Four{1, 1, 0, 0})};
  run.report = integrate(stepper, run.y, {0, period}, tolerance{.rtol = rtol, .max_steps = 20000});
  return run;
}
/// The same with z and w put in: two ordinary equations.
Dae solve_ode(auto scheme, double rtol) {
  Dae run{};
  Two y{0, 0};
  const shared_force::OfStateAndTime<Two> rate{[](const Two& u, double t) -> Two {
    return {(-u[0] - u[1] + std::sin(t)) / 1e-3, u[0] - u[1]};
  }};
  PhiStepper stepper{y, rate, scheme};
  run.report = integrate(stepper, y, {0, period}, tolerance{.rtol = rtol, .max_steps = 20000});
  run.y << y[0], y[1], (-y[0] - y[1] + std::sin(period)) / 1e-3, y[0] - y[1];
  return run;
}

// ---- a charge in a magnetic field ----

struct Gyration {
  Outcome outcome;
  double radius, fastest;
};
/// m = 3, q = 1.5, B = 2, v = 2: once round in 2π at the radius 2. A thousand turns.
Gyration gyrate(auto scheme, int steps_a_turn) {
  using Three = Eigen::Vector3d;
  const Three field{0, 0, 2};
  Motion<Three> y{Three{0, 0, 0}, Three{2, 0, 0}};
  const shared_force::OfMotion<Three> lorentz{
      [=](const Three&, const Three& v) -> Three { return 1.5 * v.cross(field); }};
  PhiStepper stepper{y, lorentz, scheme, mass(3.0)};
  double lowest = 0, fastest = 0;
  const auto look = [&](double, const Motion<Three>& at) {
    lowest = std::min(lowest, at.r.y());
    fastest = std::max(fastest, at.v.norm());
  };
  const RunReport report = integrate(stepper, y, {0, 1000 * period}, fixed(period / steps_a_turn), look);
  return {report.outcome, -lowest / 2, fastest};
}

}  // namespace

TEST_CASE("a differential-algebraic equation at rtol 1e-10 and its ordinary form end at one state") {
  const Dae dae = solve_dae(radau, 1e-10), ode = solve_ode(radau, 1e-10), rosenbrock = solve_dae(rodas5p, 1e-10);
  REQUIRE(dae.report);
  REQUIRE(ode.report);
  REQUIRE(rosenbrock.report);
  CHECK((dae.y - ode.y).head(2).norm() <= 1e-8);
  CHECK((rosenbrock.y - ode.y).head(2).norm() <= 1e-8);
  CHECK(dae.report.statistics.steps <= 100);
}
TEST_CASE("rodas5p on a differential-algebraic equation takes few steps more than on its ordinary form") {
  CHECK(solve_dae(rodas5p, 1e-10).report.statistics.steps <= 3 * solve_ode(rodas5p, 1e-10).report.statistics.steps);
}
// A probe of a step's rounding begins with a check of its start, which is not the step.
TEST_CASE("without atol a differential-algebraic equation keeps its rtol under every stiff scheme") {
  const Four right = solve_ode(radau, 1e-12).y;
  const auto keeps = [&](auto scheme, double most) {
    for (const double rtol : {1e-3, 1e-6, 1e-8}) {
      const Dae run = solve_dae(scheme, rtol);
      CAPTURE(rtol, run.report.message(), (run.y - right).norm() / rtol);
      if (run.report.outcome == Outcome::too_many_steps) continue;
      CHECK(run.report);
      CHECK((run.y - right).cwiseAbs().maxCoeff() <= most * rtol);
    }
  };
  keeps(rodas4, 10), keeps(rodas5p, 10), keeps(rodas4p2, 10), keeps(radau, 10), keeps(tr_bdf2, 30);
}

TEST_CASE("a charge in a magnetic field keeps its speed under midpoint, and is on a circle of the scheme's radius") {
  for (const int steps : {50, 10}) {
    const Gyration run = gyrate(midpoint, steps);
    CHECK(run.outcome == Outcome::success);
    CHECK(run.fastest == Approx(2).epsilon(1e-9));
    CHECK(run.radius <= 2 * (1 + 1.1 * std::pow(period / 2 / steps, 2)));
  }
}
