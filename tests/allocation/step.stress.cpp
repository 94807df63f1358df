// No heap allocation of ours in `step` after construction: every scheme, every kind of mass. In short:
// step.test.cpp.
#define EIGEN_RUNTIME_NO_MALLOC  // a second, independent witness: Eigen asserts where it allocates
#include "allocation/step_cases.hpp"

TEST_CASE("every scheme, dynamic motion, Newton by differences: nothing") {
  states::for_each_motion_scheme([](const char* name, auto scheme) {
    under_test = name;
    check_none(motion(30), Chain{}, scheme);
  });
  under_test = "";
}
TEST_CASE("every scheme, fixed motion: nothing, by value too") {
  const auto by_value = [](const states::Fixed& r, const states::Fixed& v) -> states::Fixed {
    return -r.array().cube() - v.array();
  };
  states::for_each_motion_scheme([&](const char* name, auto scheme) {
    under_test = name;
    check_none(states::SecondOrder<states::Fixed>{}.state, by_value, scheme);
  });
  under_test = "";
}
TEST_CASE("schemes of high order, dynamic: nothing") {
  const Dynamic y = Dynamic::LinSpaced(30, -1, 1);
  check_none(motion(30), Chain{}, rodas5p);
  check_none(y, AnalyticChain{}, rodas4);
  check_none(y, AnalyticChain{}, radau);
  check_none(y, Chain{}, tsit5);
  check_none(motion(30), Chain{}, rkn86);
  check_none(motion(30), Chain{}, dop853);
  check_none(motion(30), Chain{}, srkn11b);
  check_none(motion(30), DampedChain{}, composed(velocity_verlet));
}
TEST_CASE("first order, dynamic, up to 300 unknowns: nothing") {
  for (const Eigen::Index n : {1, 17, 100, 300}) {
    CAPTURE(n);
    check_none(Dynamic(Dynamic::LinSpaced(n, -1, 1)), Chain{}, trapezoidal);
    check_none(Dynamic(Dynamic::LinSpaced(n, -1, 1)), AnalyticChain{}, midpoint);
  }
}
TEST_CASE("velocities, masses of every kind, a sum, a tolerance: nothing") {
  check_none(motion(30), DampedChain{}, velocity_verlet);
  check_none(motion(30), DampedChain{}, phi(0.7), mass(2.0));
  check_none(motion(30), Chain{}, trapezoidal, mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none(motion(30), Chain{}, forward_euler, mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(30, 30))));
  check_none(motion(30), Chain{}, trapezoidal, mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(30, 30))));
  check_none(motion(30), Chain{} + LinearDrag{0.1} + Gravity{Eigen::Vector3d(0, 0, -1)}, trapezoidal);
  check_none(motion(30), Chain{}, backward_euler, newton({.rtol = 1e-6, .atol = 1e-9}));
}
