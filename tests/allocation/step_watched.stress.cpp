// No heap allocation of ours in `step` after construction: steps that are watched, rejected or doubled, and controlled
// runs. In short: step.test.cpp.
#define EIGEN_RUNTIME_NO_MALLOC  // a second, independent witness: Eigen asserts where it allocates
#include "allocation/step_watched.hpp"

TEST_CASE("watched, rejected and doubled steps: nothing") {
  states::for_each_motion_scheme([](const char* name, auto scheme) {
    under_test = name;
    check_none_watched(motion(30), Chain{}, scheme);
    check_none_watched(motion(30), DampedChain{}, scheme);
  });
  under_test = "";
  check_none_watched(Dynamic(Dynamic::LinSpaced(100, -1, 1)), AnalyticChain{}, tr_bdf2);
  check_none_watched(motion(30), Chain{}, trapezoidal, mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none_watched(motion(30), Chain{}, tr_bdf2, mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(30, 30))));
  check_none_watched(motion(30), Chain{}, trapezoidal, fixed_point({.depth = 3}));
}
TEST_CASE("high order for motion: nothing") {
  check_none(motion(30), Chain{}, srkn11b);
  check_none(motion(30), DampedChain{}, composed(velocity_verlet));
  check_none(motion(30), Chain{}, compensated(rkn1210), mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(30, 30))));
  check_none_watched(motion(30), Chain{}, rkn86, mass(Dynamic::LinSpaced(30, 1, 2)));
  check_none_run(motion(30), Chain{}, rkn86, tolerance{.rtol = 1e-11});
  check_none_run(motion(30), Chain{}, dop853, tolerance{.rtol = 1e-11});
}
TEST_CASE("controlled runs, after their first steps: nothing") {
  for (const auto filter : {StepFilter::automatic, StepFilter::predictive}) {
    const tolerance control{.rtol = 1e-4, .filter = filter};
    check_none_run(motion(30), Chain{}, velocity_verlet, control);
    check_none_run(motion(30), DampedChain{}, trapezoidal, control);
    check_none_run(motion(30), DampedChain{}, midpoint, control);
    check_none_run(Dynamic(Dynamic::LinSpaced(100, -1, 1)), Chain{}, tr_bdf2, control);
  }
  check_none_run(motion(30), Chain{}, velocity_verlet,
                 tolerance{.rtol = 1e-4, .atol = Dynamic(Dynamic::Ones(60) * 1e-4)});
  check_none_run(motion(30), Chain{}, trapezoidal, iteration_control{.first_step = 0.01, .max_step = 0.05});
}
TEST_CASE("sampled runs, after their first steps: nothing") {
  const tolerance control{.rtol = 1e-5, .max_step = 0.05};
  const Dynamic y = Dynamic::LinSpaced(30, -1, 1);
  check_none_sampled(motion(30), DampedChain{}, trapezoidal, control, 0.0005);
  check_none_sampled(y, AnalyticChain{}, tr_bdf2, control, 0.0005);
  check_none_sampled(y, AnalyticChain{}, rodas4, control, 0.002);
  check_none_sampled(y, AnalyticChain{}, radau, control, 0.002);
  check_none_sampled(motion(30), Chain{}, rkn86, control, 0.002);
  check_none_sampled(motion(30), Chain{}, dop853, control, 0.002);
  check_none_sampled(motion(30), Chain{}, velocity_verlet, fixed(0.05), 0.002);
  check_none_sampled(motion(30), Chain{}, trapezoidal, fixed(0.05), 0.002);
  // A lambda with captures can't be assigned: the stepper's copy makes it anew in its place.
  Dynamic psi(30);
  const double stiffness = 2;
  const auto captures = [&psi, stiffness](const Dynamic& x) -> const Dynamic& { return psi = -stiffness * x; };
  check_none_sampled(y, captures, trapezoidal, control, 0.0005);
}
