// NaN, infinity or an exception at every force call of a step: the state keeps every bit, and nothing is silent.
#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>
#include <string>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace {

enum class Trouble { nan, inf, exception };

/// Goes wrong at its `at`-th call, and with `lasting` ever after.
struct Fault {
  int calls = 0, at = -1;
  bool lasting = true;
  Trouble trouble = Trouble::nan;
  Eigen::Index where = 4;

  void strike(auto& f) {
    const int call = calls++;
    if (at < 0 || (lasting ? call < at : call != at)) return;
    if (trouble == Trouble::exception) throw std::runtime_error("struck");
    component(f, where) = trouble == Trouble::nan ? std::nan("") : HUGE_VAL;
  }
};
struct Struck {  // f(r) or f(y)
  Fault* fault;
  auto operator()(const auto& r) const {
    auto f = Pull{}(r);
    fault->strike(f);
    return f;
  }
};
struct StruckDamped {  // f(r, v, t)
  Fault* fault;
  auto operator()(const auto& r, const auto& v, double t) const {
    auto f = DampedPull{}(r, v, t);
    fault->strike(f);
    return f;
  }
};
struct StruckAdding : ForceTerm {
  Fault* fault;
  explicit StruckAdding(Fault* f) : fault{f} {}
  void add(double t, const auto& y, auto& out) const {
    out.force += DampedPull{}(y.r, y.v, t);
    fault->strike(out.force);
  }
};

/// The second step of a run, so that whatever may be carried is; edited, so that the state is not what the stepper left.
template <class Case, class Force>
void inject(auto scheme, bool edited) {
  Fault fault;
  int calls_of_a_step = 0;
  Eigen::VectorXd good;
  for (int at = -1; at < calls_of_a_step; ++at)
    for (const bool lasting : {true, false})
      for (const Trouble trouble : {Trouble::nan, Trouble::inf, Trouble::exception}) {
        fault = {};
        Case c;
        PhiStepper stepper{c.state, Force{&fault}, scheme};
        REQUIRE(stepper.step(c.state, 0.1, 0.1));
        if (edited) component(std::get<0>(Blocks<typename Case::State>::all(c.state)), 1) += 0.01;
        fault = {.at = at, .lasting = lasting, .trouble = trouble};
        const Eigen::VectorXd before = numbers(c.state);
        CAPTURE(at, lasting, static_cast<int>(trouble));
        if (at < 0) {
          REQUIRE(stepper.step(c.state, 0.2, 0.1));
          calls_of_a_step = fault.calls;
          good = numbers(c.state);
          continue;
        }
        try {
          const StepReport report = stepper.step(c.state, 0.2, 0.1);
          CHECK(trouble != Trouble::exception);
          if (report) {  // Newton may step around a fault that passes, but never to another answer
            CHECK_FALSE(lasting);
            CHECK(distance(numbers(c.state), good) <= 1e-13);
            continue;
          }
          CHECK((report.outcome() == Outcome::non_finite_force || report.outcome() == Outcome::non_finite_jacobian));
          CHECK_THAT(report.message(), contains("t = 0.2") && contains("dt = 0.1") && contains("Try: "));
          if (lasting && report.outcome() == Outcome::non_finite_force)
            CHECK_THAT(report.message(), contains("component"));
        } catch (const std::runtime_error& error) {
          CHECK(trouble == Trouble::exception);
          CHECK(error.what() == std::string("struck"));
        }
        CHECK(same_bits(numbers(c.state), before));
        // And the stepper is none the worse for it.
        fault.at = -1;
        REQUIRE(stepper.step(c.state, 0.2, 0.1));
        CHECK(distance(numbers(c.state), good) <= 1e-13);
      }
  CHECK(calls_of_a_step > 0);
}
template <class Case, class Force>
void inject(auto scheme) {
  inject<Case, Force>(scheme, false);
  inject<Case, Force>(scheme, true);
}

}  // namespace

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
  check(forward_euler), check(velocity_verlet), check(trapezoidal), check(backward_euler);
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
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    const auto check = [&](auto scheme) {
      SecondOrder<Dynamic> c;
      PhiStepper stepper{c.state, DampedPull{}, scheme};
      REQUIRE(stepper.step(c.state, 0, 0.1));
      c.state.v[4] = bad;
      const Eigen::VectorXd before = numbers(c.state);
      const StepReport report = stepper.step(c.state, 0.1, 0.1);
      CHECK(report.outcome() == Outcome::non_finite_state);
      CHECK(report.failure().block == 1);
      CHECK(report.failure().index == 4);
      CHECK(same_bits(numbers(c.state), before));
    };
    check(forward_euler), check(velocity_verlet), check(trapezoidal), check(midpoint);
  }
}
