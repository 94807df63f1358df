// The forms that a force may take: all forms of one force give the same steps. Under all kinds of schemes: the full
// tier, force_velocity.full.cpp.
#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <type_traits>

#include "contract/force_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"
#if PHISTEP_QUICK
#include <phistep/phistep.hpp>
#endif
#if PHISTEP_FULL
#include <phistep/autodiff.hpp>
#include <phistep/force/local.hpp>
#endif

using namespace phistep;
using namespace force_cases;

#if PHISTEP_QUICK

TEST_CASE("f(r): returning, generic, by const reference, by std::ref, as a function") {
  const Vec expected = verlet(pull);
  check_same(verlet([](const auto& r) { return Vec(-k * r); }), expected);
  Vec kept;
  check_same(verlet([&kept](const Vec& r) -> const Vec& { return kept = -k * r; }), expected);
  check_same(verlet(std::ref(pull)), expected);
  check_same(verlet([](Eigen::Ref<const Vec> r) -> Vec { return -k * r; }), expected);
  check_same(verlet(std::function<Vec(const Vec&)>(pull)), expected);
  check_same(verlet(term(pull)), expected);
}

TEST_CASE("f(r, v): returning, accumulating, with Jacobian, as a sum, by automatic differentiation") {
  // Those with Jacobian are implicit: force_velocity.full.cpp.
  Vec returning, accumulating, sum;
  step_ten(damped, forward_euler, returning);
  step_ten(Adding{}, forward_euler, accumulating);
  step_ten(term(pull) + LinearDrag{c}, forward_euler, sum);
  CHECK(distance(accumulating, returning) <= 1e-14);
  CHECK(distance(sum, returning) <= 1e-14);
}

TEST_CASE("f(r, v, t): time arrives") {
  Vec returning, accumulating, timeless;
  step_ten(driven, forward_euler, returning);
  step_ten(AddingTimed{}, forward_euler, accumulating);
  step_ten(damped, forward_euler, timeless);
  CHECK(distance(accumulating, returning) <= 1e-14);
  CHECK(distance(returning, timeless) > 0.1);
}

TEST_CASE("arity alone decides: a body is never compiled with the wrong types") {
  // Either body is a hard error if instantiated with one argument more or less, or with a vector for t.
  const auto two = [](const auto& r, const auto& v) -> Vec { return -r - v.cwiseAbs2().eval(); };
  const auto one = [](const auto& r) -> Vec { return -r.cwiseAbs2(); };
  const auto timed = [](const auto& y, auto t) -> Vec { return -y * std::pow(t, 1.5); };
  states::SecondOrder<Vec> s;
  Vec y = Vec::Ones(3);
  CHECK(PhiStepper{s.state, two, forward_euler}.step(s.state, 0, 0.1));
  CHECK(PhiStepper{s.state, one, forward_euler}.step(s.state, 0, 0.1));
  CHECK(PhiStepper{y, timed, forward_euler}.step(y, 1, 0.1));
}

TEST_CASE("a user's force in terms and references, however they nest, is that force with all that it offers") {
  AddingTimed adding;
  const WithJacobian returning;
  auto inner = term(std::ref(adding));
  const auto once = std::ref(adding);
  const auto is_adding = [](auto wrapped) {
    static_assert(std::is_same_v<Unwrapped<decltype(wrapped)>, AddingTimed>);
    return &unwrap(wrapped);
  };
  CHECK(is_adding(std::ref(adding)) == &adding);
  CHECK(is_adding(inner) == &adding);
  CHECK(is_adding(std::ref(inner)) == &adding);
  CHECK(is_adding(std::cref(inner)) == &adding);
  CHECK(is_adding(term(std::ref(inner))) == &adding);
  CHECK(is_adding(at(forward_euler, std::ref(once))) == &adding);
  CHECK(is_adding(term(at(forward_euler, inner))) == &adding);
  static_assert(std::is_same_v<Unwrapped<decltype(term(std::cref(returning)))>, WithJacobian>);

  Vec direct, by_reference, direct_kicks, kicks;
  step_ten(adding, forward_euler, direct);
  step_ten(term(std::ref(adding)), forward_euler, by_reference);
  CHECK(distance(by_reference, direct) == 0);
  step_ten(at(forward_euler, term(adding)) + LinearDrag{c}, trapezoidal, direct_kicks);
  step_ten(at(forward_euler, std::ref(adding)) + LinearDrag{c}, trapezoidal, kicks);
  CHECK(distance(kicks, direct_kicks) == 0);
  const Statistics counts = step_ten(term(std::cref(returning)) + LinearDrag{0.0}, trapezoidal, by_reference);
  const Statistics wanted = step_ten(term(returning) + LinearDrag{0.0}, trapezoidal, direct);
  CHECK(counts.force_calls == wanted.force_calls);  // differences would be calls
  CHECK(distance(by_reference, direct) == 0);
}

TEST_CASE("a force that can't be copied works by std::ref, and one that can only move is moved in") {
  struct Pinned {
    std::unique_ptr<double> stiffness = std::make_unique<double>(k);
    Vec operator()(const Vec& r) const { return -*stiffness * r; }
  };
  Pinned pinned;
  const Vec expected = verlet(pull);
  check_same(verlet(std::ref(pinned)), expected);
  states::SecondOrder<Vec> s;
  PhiStepper stepper{s.state, Pinned{}, velocity_verlet};
  for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(s.state, 0, 0.1));
  CHECK(distance(numbers(s.state), expected) <= 1e-13);
}

TEST_CASE("a result of the wrong size is an outcome and leaves the state") {
  states::SecondOrder<Vec> s;
  const Vec before = numbers(s.state);
  int size = 7;
  const auto other = [&size](const Vec&) -> Vec { return Vec::Zero(size); };
  PhiStepper stepper{s.state, other, velocity_verlet};
  const StepReport report = stepper.step(s.state, 0.5, 0.1);
  CHECK(report.outcome() == Outcome::wrong_size);
  CHECK_THAT(report.message(), contains("7 x 1") && contains("t = 0.5") && contains("dt = 0.1") && contains("Try"));
  CHECK(states::same_bits(numbers(s.state), before));
  CHECK(stepper.statistics().failed_steps == 1);
  size = 6;
  CHECK(stepper.step(s.state, 0.5, 0.1));
}

#elif PHISTEP_FULL
// The forms that a force may take: all forms, under all kinds of schemes.

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

namespace {
struct Resizing : ForceTerm {
  void add(double, const auto&, auto& out) const { out.force = Vec::Zero(5); }
};
}  // namespace

TEST_CASE("a result of the wrong size is an outcome and leaves the state") {
  const auto check = [](auto force, auto scheme, int term = -1) {
    states::SecondOrder<Vec> s;
    const Vec before = numbers(s.state);
    PhiStepper stepper{s.state, force, scheme};
    const StepReport report = stepper.step(s.state, 0, 0.1);
    CHECK(report.outcome() == Outcome::wrong_size);
    CHECK(report.failure().term == term);
    CHECK(states::same_bits(numbers(s.state), before));
    // In a run, too: at its start, inside of it, where somebody looks between its steps.
    CHECK(integrate(stepper, s.state, {0, 1}, tolerance{}).outcome == Outcome::wrong_size);
    CHECK(integrate(stepper, s.state, {0, 1}, fixed(0.1)).outcome == Outcome::wrong_size);
    CHECK(states::same_bits(numbers(s.state), before));
    Halving halving{PhiStepper{s.state, force, scheme}, 3};
    CHECK(halving.step(s.state, 0, 0.1).outcome() == Outcome::wrong_size);
    CHECK(halving.statistics().halvings == 0);  // no smaller step would do
  };
  const auto shorter = [](const Vec&) -> Vec { return Vec::Zero(5); };
  const auto longer = [](const Vec&) -> Vec { return Vec::Zero(7); };
  static Vec own = Vec::Zero(5);
  check(shorter, forward_euler), check(longer, velocity_verlet), check(shorter, trapezoidal);
  check([](const Vec&) -> const Vec& { return own; }, forward_euler);
  check(shorter, rkn86), check(longer, rodas4), check(shorter, radau), check(longer, tr_bdf2);
  check(term(pull) + term(shorter), velocity_verlet, 1);
  check(Resizing{}, velocity_verlet), check(term(pull) + Resizing{}, trapezoidal, 1);
}
TEST_CASE("a result of the wrong size between a run's steps ends it with an outcome") {
  states::SecondOrder<Vec> s;
  int size = 6;
  const auto force = [&size](const Vec& r) -> Vec { return Vec::Constant(size, -r[0]); };
  PhiStepper stepper{s.state, force, velocity_verlet};
  // Whoever looks inside of a step asks for its slopes.
  const RunReport report = integrate(stepper, s.state, {0, 1}, fixed(0.25), [&size](const auto& step) {
    if (step.t1() < 0.6) return;
    size = 7;
    static_cast<void>(step.at(step.t0() + 0.1));
  });
  CHECK(report.outcome == Outcome::wrong_size);
  CHECK(report.t == 0.75);
}
TEST_CASE("a field of the wrong size is an outcome") {
  states::SecondOrder<states::Columns> s;
  const auto two = [](const Eigen::Vector3d&) -> Vec { return Vec::Zero(2); };
  PhiStepper stepper{s.state, external_field<3>(two), velocity_verlet};
  CHECK(stepper.step(s.state, 0, 0.1).outcome() == Outcome::wrong_size);
}

TEST_CASE("a Jacobian of the wrong size is an outcome and leaves the state") {
  struct Wrong : WithJacobian {
    MotionJacobian<Eigen::MatrixXd> jacobian(const Vec&, const Vec&) const {
      return {Eigen::MatrixXd::Zero(6, 6), Eigen::MatrixXd::Zero(5, 6)};
    }
  };
  states::SecondOrder<Vec> s;
  const Vec before = numbers(s.state);
  PhiStepper stepper{s.state, Wrong{}, trapezoidal};
  const StepReport report = stepper.step(s.state, 0, 0.1);
  CHECK(report.outcome() == Outcome::wrong_size);
  CHECK_THAT(report.message(), contains("5 x 6"));
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

#endif
