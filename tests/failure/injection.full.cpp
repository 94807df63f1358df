// injection: the full product and what is dear to compile. The quick half is injection.test.cpp.
#include "failure/injection_cases.hpp"

using namespace injection_cases;

TEST_CASE("every call of every scheme, dynamic motion, f(r)") {
  for_each_motion_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    inject<SecondOrder<Dynamic>, Struck>(scheme);
  });
}

TEST_CASE("every call of every scheme, fixed motion, f(r, v, t)") {
  for_each_motion_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    inject<SecondOrder<Fixed>, StruckDamped>(scheme);
  });
}

TEST_CASE("every call of every scheme, first order in a strided view") {
  for_each_first_order_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    inject<FirstOrder<Strided>, Struck>(scheme);
  });
}

TEST_CASE("an accumulating force, on particles as columns") {
  inject<SecondOrder<Columns>, StruckAdding>(forward_euler);
  inject<SecondOrder<Columns>, StruckAdding>(velocity_verlet);
  inject<SecondOrder<Columns>, StruckAdding>(phi(0.7));
}

TEST_CASE("the message names the component, the particle and the term") {
  check_message(forward_euler), check_message(velocity_verlet);
  check_message(trapezoidal), check_message(backward_euler);
}

TEST_CASE("a mass matrix does not smear the blame over all components") {
  Fault fault{.at = 0, .where = 3};
  Eigen::MatrixXd M = Eigen::MatrixXd::Constant(6, 6, 0.1);
  M.diagonal().setConstant(2);
  const auto check = [&](auto scheme) {
    fault.calls = 0;
    SecondOrder<Dynamic> c;
    PhiStepper stepper{c.state, Struck{&fault}, scheme, mass(M)};
    const StepReport report = stepper.step(c.state, 0, 0.1);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK(report.failure().index == 3);
    CHECK(same_bits(numbers(c.state), numbers(SecondOrder<Dynamic>{}.state)));
  };
  check(forward_euler), check(trapezoidal);
}

TEST_CASE("a force that returns a reference is blamed by name too") {
  Dynamic kept;
  Fault fault{.at = 0, .where = 2};
  const auto force = [&](const Dynamic& r) -> const Dynamic& {
    kept = Pull{}(r);
    fault.strike(kept);
    return kept;
  };
  SecondOrder<Dynamic> c;
  const auto check = [&](auto scheme, int at) {
    fault.calls = 0, fault.at = at;
    PhiStepper stepper{c.state, force, scheme};
    const StepReport report = stepper.step(c.state, 0, 0.1);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK(report.failure().index == 2);
    CHECK(same_bits(numbers(c.state), numbers(SecondOrder<Dynamic>{}.state)));
  };
  check(forward_euler, 0), check(velocity_verlet, 0), check(velocity_verlet, 1), check(trapezoidal, 0);
}

TEST_CASE("a state that is not finite is blamed before the force that it spoils") {
  check_bad_state(DampedPull{}, forward_euler), check_bad_state(DampedPull{}, velocity_verlet);
  check_bad_state(DampedPull{}, trapezoidal), check_bad_state(DampedPull{}, midpoint);
}
