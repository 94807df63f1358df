// No heap allocation of ours in `step` after construction: split terms, implicit springs, whole runs. In short:
// step.test.cpp.
#define EIGEN_RUNTIME_NO_MALLOC  // a second, independent witness: Eigen asserts where it allocates
#include "allocation/step_cases.hpp"

TEST_CASE("split terms, Rannacher's start, a step around a step: nothing") {
  const auto kicks = at(forward_euler, Chain{}) + at(forward_euler, Gravity{Eigen::Vector3d(0, 0, -1)});
  check_none(motion(30), Chain{} + kicks, trapezoidal);
  check_none(motion(30), Chain{} + kicks + LinearDrag{0.1}, tr_bdf2, mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none(motion(30), Chain{} + at(forward_euler, DampedChain{}), midpoint,
             mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(30, 30))));
  check_none(motion(30), Chain{}, rannacher(3));
  check_none(motion(30), Chain{} + seldom(2, Chain{}) + seldom(4, Gravity{Eigen::Vector3d(0, 0, -1)}), velocity_verlet,
             mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none(motion(30), DampedChain{} + seldom(3, Chain{}), velocity_verlet);
}
TEST_CASE("springs, implicitly: nothing once the net is known, in a clamped step neither") {
  const auto check = [](double length) {
    auto y = motion(30);
    PhiStepper stepper{y, spring_network<3>({{0, 1, 5, length}, {1, 2, 5, length}}) + LinearDrag{0.1}, backward_euler};
    REQUIRE(stepper.step(y, 0, 0.1));
    heap::count = 0, heap::counting = true;
    for (int n = 0; n < 10; ++n) static_cast<void>(stepper.step(y, 0, 3.0));
    heap::counting = false;
    CHECK(heap::count == 0);
    return stepper.statistics().fallbacks;
  };
  CHECK(check(0.01) == 0);
  CHECK(check(50) > 0);
}

TEST_CASE("integrate: nothing but what observers do") {
  auto y = motion(30);
  PhiStepper stepper{y, Chain{}, velocity_verlet};
  heap::count = 0, heap::counting = true;
  const RunReport report = integrate(stepper, y, {0, 1}, fixed(0.01), [](double, const Motion<Dynamic>&) {});
  heap::counting = false;
  CHECK(report);
  CHECK(heap::count == 0);
}
