// The forms that a force may take: all forms, under all kinds of schemes. The quick half: force.test.cpp.
#include <phistep/autodiff.hpp>

#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>

#include "contract/force_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace force_cases;

TEST_CASE("f(r): returning, generic, by const reference, by std::ref, as a function") {
  const Steps expected = steps(pull);
  check_same(steps([](const auto& r) { return Vec(-k * r); }), expected);
  Vec kept;
  check_same(steps([&kept](const Vec& r) -> const Vec& { return kept = -k * r; }), expected);
  check_same(steps(std::ref(pull)), expected);
  check_same(steps([](Eigen::Ref<const Vec> r) -> Vec { return -k * r; }), expected);
  check_same(steps(std::function<Vec(const Vec&)>(pull)), expected);
  check_same(steps(term(pull)), expected);
}

TEST_CASE("a force that can't be copied works by std::ref, and one that can only move is moved in") {
  struct Pinned {
    std::unique_ptr<double> stiffness = std::make_unique<double>(k);
    Vec operator()(const Vec& r) const { return -*stiffness * r; }
  };
  Pinned pinned;
  const Steps expected = steps(pull);
  check_same(steps(std::ref(pinned)), expected);
  states::SecondOrder<Vec> s;
  PhiStepper stepper{s.state, Pinned{}, forward_euler};
  for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(s.state, 0, 0.1));
  CHECK(distance(numbers(s.state), expected.explicit_) <= 1e-14);
}

TEST_CASE("a result of the wrong size throws and leaves the state") {
  const auto check = [](auto force, auto scheme) {
    states::SecondOrder<Vec> s;
    const Vec before = numbers(s.state);
    PhiStepper stepper{s.state, force, scheme};
    CHECK_THROWS_AS(stepper.step(s.state, 0, 0.1), std::invalid_argument);
    CHECK(states::same_bits(numbers(s.state), before));
  };
  const auto shorter = [](const Vec&) -> Vec { return Vec::Zero(5); };
  const auto longer = [](const Vec&) -> Vec { return Vec::Zero(7); };
  static Vec own = Vec::Zero(5);
  check(shorter, forward_euler), check(longer, velocity_verlet), check(shorter, trapezoidal);
  check([](const Vec&) -> const Vec& { return own; }, forward_euler);
}

TEST_CASE("a Jacobian of the wrong size throws and leaves the state") {
  struct Wrong : WithJacobian {
    MotionJacobian<Eigen::MatrixXd> jacobian(const Vec&, const Vec&) const {
      return {Eigen::MatrixXd::Zero(6, 6), Eigen::MatrixXd::Zero(5, 6)};
    }
  };
  states::SecondOrder<Vec> s;
  const Vec before = numbers(s.state);
  PhiStepper stepper{s.state, Wrong{}, trapezoidal};
  CHECK_THROWS_AS(stepper.step(s.state, 0, 0.1), std::invalid_argument);
  CHECK(states::same_bits(numbers(s.state), before));
}

TEST_CASE("a Map given to a force of plain vectors does not dangle") {
  states::SecondOrder<states::Strided> s;
  states::SecondOrder<Vec> plain;
  PhiStepper a{s.state, damped, trapezoidal};
  PhiStepper b{plain.state, damped, trapezoidal};
  for (int n = 0; n < 5; ++n) REQUIRE((a.step(s.state, 0, 0.1) && b.step(plain.state, 0, 0.1)));
  CHECK(states::same_bits(numbers(s.state), numbers(plain.state)));
}
