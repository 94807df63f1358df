// NaN, infinity or an exception at every force call of a step: the state keeps every bit, and nothing is silent.
#include "failure/injection_cases.hpp"

using namespace injection_cases;

TEST_CASE("every call of every scheme, dynamic motion, f(r)") {
  inject<SecondOrder<Dynamic>, Struck>(velocity_verlet);
  inject<SecondOrder<Dynamic>, Struck>(trapezoidal);
}

TEST_CASE("every call of every scheme, fixed motion, f(r, v, t)") {
  inject<SecondOrder<Fixed>, StruckDamped>(symplectic_euler);
}

TEST_CASE("every call of every scheme, first order in a strided view") {
  inject<FirstOrder<Strided>, Struck>(forward_euler);
}

TEST_CASE("the message names the component, the particle and the term") {
  Fault fault{.at = 0, .where = 5};
  SecondOrder<Columns> c;
  const auto check = [&](auto scheme) {
    fault.calls = 0;
    PhiStepper stepper{c.state, LinearDrag{0.1} + StruckAdding{&fault}, scheme};
    const StepReport report = stepper.step(c.state, 0.5, 0.25);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK_THAT(report.message(), contains("component 5") && contains("particle 1, row 2") && contains("term 1") &&
                                     contains("t = 0.5") && contains("dt = 0.25"));
  };
  check(forward_euler);
}

TEST_CASE("a state that is not finite is blamed before the force that it spoils") {
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    const auto check = [&](auto scheme) {
      SecondOrder<Dynamic> c;
      Fault none;
      PhiStepper stepper{c.state, Struck{&none}, scheme};
      REQUIRE(stepper.step(c.state, 0, 0.1));
      c.state.v[4] = bad;
      const Eigen::VectorXd before = numbers(c.state);
      const StepReport report = stepper.step(c.state, 0.1, 0.1);
      CHECK(report.outcome() == Outcome::non_finite_state);
      CHECK(report.failure().block == 1);
      CHECK(report.failure().index == 4);
      CHECK(same_bits(numbers(c.state), before));
    };
    check(velocity_verlet), check(trapezoidal);
  }
}
