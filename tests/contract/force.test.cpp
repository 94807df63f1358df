// The forms that a force may take: all forms of one force give the same steps.
#include <phistep/autodiff.hpp>

#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using states::distance;
using states::numbers;
using Vec = Eigen::VectorXd;
using Y = Motion<Vec>;

namespace {

constexpr double k = 3.0, c = 0.4;

/// Ten steps of every kind of scheme: explicit, Verlet, Newton.
struct Steps {
  Vec explicit_, verlet, newton;
  Statistics newton_counts;
};
template <class F>
Steps steps(F force) {
  Steps result;
  const auto run = [&force](auto scheme, Vec& out) {
    states::SecondOrder<Vec> s;
    PhiStepper stepper{s.state, force, scheme};
    for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(s.state, 0.1 * n, 0.1));
    out = numbers(s.state);
    return stepper.statistics();
  };
  run(forward_euler, result.explicit_);
  run(velocity_verlet, result.verlet);
  result.newton_counts = run(trapezoidal, result.newton);
  return result;
}
void check_same(const Steps& a, const Steps& b) {
  CHECK(distance(a.explicit_, b.explicit_) <= 1e-14);
  CHECK(distance(a.verlet, b.verlet) <= 1e-13);
  CHECK(distance(a.newton, b.newton) <= 1e-12);
}

const auto pull = [](const Vec& r) -> Vec { return -k * r; };
const auto damped = [](const Vec& r, const Vec& v) -> Vec { return -k * r - c * v; };
const auto driven = [](const Vec& r, const Vec& v, double t) -> Vec { return (-k * r - c * v).array() + std::sin(t); };

struct Adding : ForceTerm {
  static constexpr bool uses_time = false;
  void add(double, const auto& y, auto& out) const { out.force -= k * y.r + c * y.v; }
};
struct AddingTimed {
  void add(double t, const auto& y, auto& out) const {
    out.force.array() += (-k * y.r - c * y.v).array() + std::sin(t);
  }
};
struct WithJacobian {
  Vec operator()(const Vec& r, const Vec& v) const { return -k * r - c * v; }
  MotionJacobian<Eigen::MatrixXd> jacobian(const Vec& r, const Vec&) const {
    const auto I = Eigen::MatrixXd::Identity(r.size(), r.size());
    return {-k * I, -c * I};
  }
};

}  // namespace

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

TEST_CASE("f(r, v): returning, accumulating, with Jacobian, as a sum, by automatic differentiation") {
  const Steps expected = steps(damped);
  check_same(steps(Adding{}), expected);
  const Steps analytic = steps(WithJacobian{});
  check_same(analytic, expected);
  check_same(steps(term(pull) + LinearDrag{c}), expected);
  const Steps dual = steps(autodiff([](const auto& r, const auto& v) {
    std::remove_cvref_t<decltype(r)> f = r;
    for (Eigen::Index i = 0; i < r.size(); ++i) f[i] = -k * r[i] - c * v[i];
    return f;
  }));
  check_same(dual, expected);
  // Differences call the force; a Jacobian of its own, or by AD, saves those calls.
  CHECK(analytic.newton_counts.force_calls < expected.newton_counts.force_calls);
  CHECK(dual.newton_counts == analytic.newton_counts);
}

TEST_CASE("f(r, v, t): time arrives") {
  check_same(steps(driven), steps(AddingTimed{}));
  CHECK(distance(steps(driven).explicit_, steps(damped).explicit_) > 0.1);
}

TEST_CASE("first order: f(y) and f(y, t), with and without Jacobian") {
  const auto run = [](auto force) {
    Vec y = Eigen::Vector3d(1, 2, 3);
    PhiStepper stepper{y, force, trapezoidal};
    for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(y, 0.1 * n, 0.1));
    return y;
  };
  struct Analytic {
    Vec operator()(const Vec& y, double t) const { return (-y.array().cube() + std::cos(t)).matrix(); }
    Eigen::MatrixXd jacobian(const Vec& y, double) const { return (-3 * y.array().square()).matrix().asDiagonal(); }
  };
  const Vec expected = run([](const Vec& y, double t) -> Vec { return -y.array().cube() + std::cos(t); });
  CHECK(distance(run(Analytic{}), expected) <= 1e-13);
  CHECK(distance(run(autodiff([](const auto& y, double t) {
                   std::remove_cvref_t<decltype(y)> f = y;
                   for (Eigen::Index i = 0; i < y.size(); ++i) f[i] = -y[i] * y[i] * y[i] + std::cos(t);
                   return f;
                 })),
                 expected) <= 1e-13);
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
