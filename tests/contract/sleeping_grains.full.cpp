// Grains with friction that fall asleep: what they remember of their contacts sleeps with them.
// Quick: particles/sleep/sleeping.test.cpp and particles/contacts/contact.test.cpp, each of its own.
#include <phistep/particles.hpp>

#include <cmath>

#include "support/catch.hpp"

using namespace phistep;
using Grains = Particles<double, 3, Spin>;
using Eigen::Vector3d;

namespace {

constexpr double R = 0.5, dt = 2e-4;
const Hooke hard{.stiffness = 1e4, .restitution = 0.3, .friction = 0.6, .rolling_friction = 0.2};
auto slope_force() {
  // Gravity is tilted by 10°: friction alone holds the grains on the plane, and each other.
  const double tilt = 10 * std::acos(-1.0) / 180;
  return Contact{hard} + Walls<Hooke>{hard, Plane<3>{Vector3d::Zero(), Vector3d::UnitZ()}} +
         Gravity{Vector3d{9.81 * std::sin(tilt), 0, -9.81 * std::cos(tilt)}};
}
/// Two grains on the plane and one on top of them.
Grains three() {
  Grains grains{(Eigen::Matrix3Xd(3, 3) << 0, 0.99, 0.495, 0, 0, 0, 0.4999, 0.4999, 1.35).finished()};
  grains.set_mass(1.0).set_radius(R);
  return grains;
}
Eigen::Matrix3Xd acceleration(auto& stepper, const Grains& y) {
  Grains out = y;
  REQUIRE(stepper.slope(0.0, y, out));
  return out.v;
}

}  // namespace

TEST_CASE("springs of contacts outlive the time that their bodies are held still") {
  Grains grains = three();
  PhiStepper stepper{grains, slope_force(), symplectic_euler};
  for (int n = 0; n < 20000; ++n) REQUIRE(stepper.step(grains, dt * n, dt));
  CHECK(grains.v.norm() < 1e-6);  // held by friction
  grains.v.setZero(), grains.omega.setZero();
  REQUIRE(stepper.step(grains, 4.0, dt));
  grains.v.setZero(), grains.omega.setZero();
  const Eigen::Matrix3Xd before = acceleration(stepper, grains);
  CHECK(before.norm() < 1e-3);

  grains.set_still({1, 1, 1});
  for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(grains, 5 + dt * n, dt));
  grains.set_still({1, 0, 1});  // one alone …
  for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(grains, 6 + dt * n, dt));
  grains.set_still({});  // … then all
  const Eigen::Matrix3Xd after = acceleration(stepper, grains);
  // The one that was free for three steps has moved by less than 1e-9; k·1e-9 = 1e-5. Without its springs, g sin 10° = 1.7.
  CHECK((after - before).norm() < 1e-4);
  for (int n = 0; n < 5000; ++n) REQUIRE(stepper.step(grains, 7 + dt * n, dt));
  CHECK(grains.v.norm() < 1e-6);
}

TEST_CASE("a heap on a slope falls asleep and costs nothing; where it lies differs by what the budget allows") {
  const auto run = [](SleepOptions options) {
    Grains grains = three();
    Sleeping stepper{PhiStepper{grains, slope_force(), symplectic_euler}, options};
    for (int n = 0; n < 40000; ++n) REQUIRE(stepper.step(grains, dt * n, dt));
    return std::pair{grains, stepper.report()};
  };
  const auto [asleep, report] = run({.speed = 1e-4});
  const auto [awake, none] = run({});
  CHECK(report.asleep == 3);
  CHECK(report.skipped > 30000);
  CHECK(none.fell_asleep == 0);
  CHECK((asleep.r - awake.r).norm() < 1e-5);
}

TEST_CASE("a ball that lands on a sleeping heap wakes it, and its blow goes through") {
  Grains grains = three();
  Sleeping stepper{PhiStepper{grains, slope_force(), symplectic_euler}, SleepOptions{.speed = 1e-3}};
  int n = 0;
  while (stepper.report().asleep < 3 && n < 60000) REQUIRE(stepper.step(grains, dt * n++, dt));
  REQUIRE(stepper.report().asleep == 3);
  Grains ball{Vector3d{0.495, 0, 4}};
  ball.set_mass(1.0).set_radius(R);
  ball.v.col(0) << 0, 0, -3;
  grains.add(ball);
  double p_before = 0, fastest = 0;
  for (int k = 0; k < 3000; ++k) {
    REQUIRE(stepper.step(grains, dt * n++, dt));
    p_before = std::max(p_before, -grains.v(2, 3));
    for (Index i = 0; i < 3; ++i) fastest = std::max(fastest, grains.v.col(i).norm());
  }
  CHECK(p_before > 3);
  CHECK(fastest > 0.5);
}

TEST_CASE("where all grains sleep, other radii, other gravity, a support that moves wake them all") {
  const auto wakes = [](auto&& act) {
    Grains grains = three();
    grains.add([] {
      Grains held{Vector3d{0, 20, 0.4999}};  // far away
      held.set_mass(1.0).set_radius(R);
      return held;
    }());
    grains.set_still({0, 0, 0, 1});
    Sleeping stepper{PhiStepper{grains, slope_force(), symplectic_euler}, SleepOptions{.speed = 1e-3}};
    int n = 0;
    while (stepper.report().asleep < 3 && n < 60000) REQUIRE(stepper.step(grains, dt * n++, dt));
    REQUIRE(stepper.report().asleep == 3);
    for (int k = 0; k < 100; ++k) REQUIRE(stepper.step(grains, dt * n++, dt));
    act(grains, stepper);
    REQUIRE(stepper.step(grains, dt * n++, dt));
    CHECK(stepper.report().asleep == 0);
    const Eigen::Matrix3Xd before = grains.r;
    for (int k = 0; k < 500; ++k) REQUIRE(stepper.step(grains, dt * n++, dt));
    return (grains.r - before).colwise().norm().head(3).minCoeff();
  };
  // In 0.1 s, g makes 5 cm.
  CHECK(wakes([](Grains& y, auto&) { y.set_radius(R / 2); }) > 0.02);
  CHECK(wakes([](Grains&, auto& stepper) { std::get<2>(stepper.stepper().force().terms).g *= -1; }) > 0.02);
  CHECK(wakes([](Grains& y, auto&) { y.r(1, 3) -= 1; }) >= 0);
  CHECK(wakes([](Grains&, auto& stepper) { stepper.reset(); }) >= 0);
}
