// Steps written into the state or through a view; the full half is in_place.full.cpp.
#include "run/stepper/in_place_cases.hpp"

using namespace in_place_cases;

TEST_CASE("in place or beside, states of all magnitudes end alike") {
  compare_random<double>(1, 40, {2, 5});
  compare_random<double>(3, 4, {120});
  compare_random<double>(2, 2, {700});  // a strided view is written in several chunks
}

TEST_CASE("what fails after the first chunk of a view was written leaves every number as it was") {
  for (const Trouble trouble : {Trouble::nan, Trouble::inf, Trouble::exception})
    for (const Index where : {Index{0}, Index{3 * 400}, Index{3 * 700 - 1}})
      for (const int at : {0, 1, 2}) {
        const std::vector<double> x(2100, 0.75), f(2100, 3.0);
        const Setting<double> s{700, x, x, f, 0.1, 6, trouble, at, where};
        CAPTURE(static_cast<int>(trouble), where, at);
        compare(s, forward_euler, mass(1.5)), compare(s, velocity_verlet, mass(1.5));
      }
}

TEST_CASE("an unedited run is done in place where overflow is excluded, and beside the state where it isn't") {
  using Eigen::VectorXd;
  const auto is_swapped_each_step = [](double scale, double f, auto scheme) {
    Motion<VectorXd> y{VectorXd::Constant(300, scale), VectorXd::Constant(300, scale)};
    PhiStepper stepper{y, [f](const VectorXd& r) -> VectorXd { return VectorXd::Constant(r.size(), f); }, scheme};
    const double* const home = y.r.data();
    bool swapped = true;
    for (int n = 0; n < 6; ++n) {
      REQUIRE(stepper.step(y, 0.1 * n, 0.1, n == 0 ? Origin::unknown : Origin::unedited));
      swapped = swapped && (y.r.data() == home) == (n % 2 == 1);
    }
    return swapped;
  };
  CHECK_FALSE(is_swapped_each_step(1, 1, forward_euler));
  CHECK_FALSE(is_swapped_each_step(1e300, 1, symplectic_euler));
  CHECK(is_swapped_each_step(1e307, 1, forward_euler));  // 300 of them are more than there is
  CHECK(is_swapped_each_step(1, 1e307, symplectic_euler));
  CHECK(is_swapped_each_step(1, 1, velocity_verlet));
}

TEST_CASE("bounds are taken anew where the state may have been edited, and after failures") {
  using Eigen::VectorXd;
  Motion<VectorXd> y{VectorXd::Zero(300), VectorXd::Ones(300)};
  bool bad = false, throws = false;
  PhiStepper stepper{y,
                     [&](const VectorXd& r) -> VectorXd {
                       if (throws) throw std::runtime_error("struck");
                       return VectorXd::Constant(r.size(), bad ? std::nan("") : 1.0);
                     },
                     forward_euler};
  REQUIRE(stepper.step(y, 0.0, 0.1, Origin::unknown));
  REQUIRE(stepper.step(y, 0.1, 0.1, Origin::unedited));
  y.v[299] = 1.7e308;
  const auto keeps_every_bit = [&](Origin origin) {
    const Motion<VectorXd> before = y;
    const StepReport report = stepper.step(y, 0.2, 1e3, origin);
    CHECK(report.outcome() == Outcome::non_finite_state);
    CHECK(report.failure().index == 299);
    CHECK(equal_blocks<Motion<VectorXd>>(y, before));
  };
  keeps_every_bit(Origin::unknown);
  keeps_every_bit(Origin::unedited);
  y.v[299] = 1;
  REQUIRE(stepper.step(y, 0.2, 0.1, Origin::unknown));
  REQUIRE(stepper.step(y, 0.3, 0.1, Origin::unedited));
  bad = true;
  CHECK(stepper.step(y, 0.4, 0.1, Origin::unedited).outcome() == Outcome::non_finite_force);
  bad = false;
  y.v[299] = 1.7e308;  // what put the state back after a failure may have put back anything
  keeps_every_bit(Origin::unedited);
  y.v[299] = 1;
  REQUIRE(stepper.step(y, 0.4, 0.1, Origin::unedited));
  throws = true;
  CHECK_THROWS(stepper.step(y, 0.5, 0.1, Origin::unedited));
  throws = false;
  y.v[299] = 1.7e308;
  keeps_every_bit(Origin::unedited);
  y.v[299] = 1;
  REQUIRE(stepper.step(y, 0.5, 0.1, Origin::unedited));
  stepper.reset();
  y.v[299] = 1.7e308;
  keeps_every_bit(Origin::unedited);
}
