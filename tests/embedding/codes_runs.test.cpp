// Three existing codes in controlled runs: a tolerance, events do what they do with a state of the library under the same
// force.
#include "embedding/codes_runs_cases.hpp"

using namespace codes_cases;

TEST_CASE("masses on springs under a tolerance") {
  after::Cloth code(36);
  before::Cloth other(36);
  check(code, other, phistep::velocity_verlet, phistep::mass(masses(other)), [](auto& stepper, auto& state) {
    return phistep::integrate(stepper, state, {0, 0.1}, phistep::tolerance{.rtol = 1e-5, .atol = 1e-7});
  });
}

TEST_CASE("an event ends the run of an existing code where it ends that of a state of the library") {
  after::Cloth code(36);
  before::Cloth other(36);
  check(
      code, other, phistep::velocity_verlet, phistep::mass(masses(other)),
      [](auto& stepper, auto& state) {
        return phistep::integrate(stepper, state, {0, 1}, phistep::fixed(1e-3),
                                  phistep::event([](const auto& y) { return y.r(2, 0) + 0.01; }, {.terminal = true}));
      },
      phistep::Outcome::stopped_by_event);
  CHECK(code.beads[0].x[2] == Approx(-0.01).margin(1e-12));
}

TEST_CASE("heat under a tolerance") {
  after::HeatPlate code(100);
  before::HeatPlate other(100);
  VectorXd y = VectorXd::Map(other.u, other.ncells);
  const auto rate = [&](const VectorXd& u) -> VectorXd {
    VectorXd::Map(other.u, other.ncells) = u;
    other.compute_rates();
    return VectorXd::Map(other.dudt, other.ncells);
  };
  const phistep::tolerance control{.rtol = 1e-4, .atol = 1e-6};
  phistep::PhiStepper by_library{y, rate, phistep::forward_euler};
  const auto right = phistep::integrate(by_library, y, {0, 0.1}, control);
  REQUIRE(right);
  in_place(code, [&](auto& state, auto force) {
    phistep::PhiStepper stepper{state, force, phistep::forward_euler};
    const auto report = phistep::integrate(stepper, state, {0, 0.1}, control);
    REQUIRE(report);
    CHECK(report.statistics.steps == right.statistics.steps);
    CHECK(report.statistics.force_calls == right.statistics.force_calls);
  });
  CHECK(distance(state_of(code), Numbers(y.begin(), y.end())) <= 1e-12);
}
