#include <phistep/phistep.hpp>

#include <cmath>

#include "support/catch.hpp"

using namespace phistep;
using Two = Eigen::Vector2d;

namespace {
/// y' = −z, 0 = z − y²: y = 1/(1+t).
Two psi(const Two& y) { return {-y[1], y[1] - y[0] * y[0]}; }
constexpr auto force = [](const Two& y) -> Two { return psi(y); };
const Two one_of_two{1, 0};
template <class Scheme>
auto stepper_for(const Two& y, Scheme scheme) {
  return PhiStepper{y, force, scheme, capacity(one_of_two)};
}
}  // namespace

TEST_CASE("a start that does not satisfy the algebraic equations is refused, and the component named") {
  const auto check = [](auto scheme) {
    Two y{1, 0.5};
    auto stepper = stepper_for(y, scheme);
    const StepReport report = stepper.step(y, 0, 0.1);
    CHECK(report.outcome() == Outcome::inconsistent_start);
    CHECK(report.failure().block == 0);
    CHECK(report.failure().index == 1);
    CHECK_THAT(report.message(), contains("component 1 of block 0"));
    CHECK(y == Two(1, 0.5));
    for (const double z : {1.01, 1 + 1e-4}) {
      y[1] = z;
      const RunReport run = integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-6, .atol = 1e-6});
      CHECK(run.outcome == Outcome::inconsistent_start);
      CHECK(run.t == 0);
      CHECK(y == Two(1, z));
    }
    y[1] = 1 + 1e-8;  // within the tolerance
    CHECK(integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-6, .atol = 1e-6}));
    CHECK(std::abs(y[0] - 0.5) <= 1e-5);
  };
  check(rodas4);
  check(rodas5p);
  check(tr_bdf2);
}

TEST_CASE(
    "a load of the algebraic equation that grows from zero at the start is consistent, one that jumps there isn't") {
  // y' = z, 0 = load − z, and all begins with zeros, without .atol.
  const auto run = [](auto scheme, double t0, auto load) {
    Two y{0, 0};
    const auto rate = [load](const Two& u, double t) -> Two { return {u[1], load(t) - u[1]}; };
    PhiStepper stepper{y, rate, scheme, capacity(one_of_two)};
    return integrate(stepper, y, {t0, t0 + 1}, tolerance{.rtol = 1e-6}).outcome;
  };
  const auto check = [&](auto scheme) {
    for (const double t0 : {0.0, 1.0, -3.0}) {
      CHECK(run(scheme, t0, [=](double t) { return std::sin(t - t0); }) == Outcome::success);
      CHECK(run(scheme, t0, [=](double t) { return t > t0 ? 1.0 : 0.0; }) == Outcome::inconsistent_start);
      CHECK(run(scheme, t0, [=](double t) { return t > t0 ? std::cos(t) : 0.0; }) == Outcome::inconsistent_start);
    }
  };
  check(radau);
  check(rodas5p);
  check(rodas4);
  check(tr_bdf2);
}

TEST_CASE("backward Euler looks at nothing of where it starts but M y") {
  const auto check = [](auto scheme) {
    Two y{1, 17}, exact{1, 1};
    auto repairs = stepper_for(y, scheme), other = stepper_for(exact, scheme);
    for (int n = 0; n < 3; ++n) {
      REQUIRE(repairs.step(y, 0, 0.1));
      REQUIRE(other.step(exact, 0, 0.1));
    }
    CHECK((y - exact).norm() <= 1e-14);
  };
  check(backward_euler);
  check(phi(1.0));
  check(phi_stage(1.0));
  Two y{1, 17};
  auto stepper = stepper_for(y, backward_euler);
  CHECK(integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-3}).outcome == Outcome::inconsistent_start);
}

TEST_CASE("a consistent start is looked at once, and each edit again") {
  Two y{1, 1};
  auto stepper = stepper_for(y, rodas4);
  // Ψ, two differences, and five more stages. A residual of zero asks for no solve.
  REQUIRE(stepper.step(y, 0, 0.1));
  CHECK(stepper.statistics().force_calls == 8);
  CHECK(stepper.statistics().solves == 6);
  REQUIRE(stepper.step(y, 0.1, 0.1));
  CHECK(stepper.statistics().solves == 12);
  y = {0.5, 0.25 + 1e-9};
  REQUIRE(stepper.step(y, 0.2, 0.1));
  CHECK(stepper.statistics().solves == 19);  // one for the check
  CHECK(stepper.statistics().factorizations == 3);
  y[0] = 0.7;
  CHECK(stepper.step(y, 0.3, 0.1).outcome() == Outcome::inconsistent_start);
  CHECK(stepper.statistics().steps == 3);
}

TEST_CASE("a run looks at its start alone, wherever its clock rounds") {
  Two y{1, 1};
  auto stepper = stepper_for(y, tr_bdf2);
  const RunReport run = integrate(stepper, y, {0.0, 1.0}, fixed(1.0 / 49));
  REQUIRE(run);
  CHECK(run.statistics.steps == 49);
  CHECK(stepper.statistics().failed_steps == 0);
}

TEST_CASE("a regular mass costs no look at the start") {
  const auto counts = [](const auto& mass) {
    Two y{1, 1};
    PhiStepper stepper{y, force, rodas4, mass};
    REQUIRE(stepper.step(y, 0, 0.01));
    return std::pair{stepper.statistics().force_calls, stepper.statistics().solves};
  };
  CHECK(counts(capacity(1.0)) == std::pair<std::int64_t, std::int64_t>{8, 6});
  CHECK(counts(capacity(Two(1, 2))) == std::pair<std::int64_t, std::int64_t>{8, 6});
}

TEST_CASE("a step that fails keeps the state and every bit of it") {
  Two y{1, 1};
  bool breaks = false;
  const auto fragile = [&breaks](const Two& x) -> Two { return breaks ? Two(std::nan(""), 0) : psi(x); };
  const auto check = [&](auto scheme) {
    y = {1, 1};
    PhiStepper stepper{y, fragile, scheme, capacity(one_of_two)};
    REQUIRE(stepper.step(y, 0, 0.1));
    const Two before = y;
    breaks = true;
    CHECK(stepper.step(y, 0.1, 0.1).outcome() == Outcome::non_finite_force);
    CHECK(y == before);
    breaks = false;
    REQUIRE(stepper.step(y, 0.1, 0.1));
  };
  check(rodas4);
  check(tr_bdf2);
  check(backward_euler);
}
