// SRKN6b and SRKN11b: order, counts, symmetry, energy over long times, failures, restarts.
#include "schemes/kick_drift_cases.hpp"

using namespace kick_drift_cases;

TEST_CASE("orders 4 and 6 in long double") {
  check_order(errors(60, [](int n) { return error_at_end<long double>(srkn6b, n); }), 4, 0.05);
  check_order(errors(10, [](int n) { return error_at_end<long double>(srkn11b, n); }), 6, 0.05);
}

TEST_CASE("force calls: six and eleven a step, and one more at the start of a run") {
  const auto calls = [](auto scheme, int steps) {
    auto y = six();
    PhiStepper stepper{y, Anharmonic{}, scheme};
    for (int n = 0; n < steps; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
    return stepper.statistics().force_calls;
  };
  CHECK(calls(srkn6b, 10) == 6 * 10 + 1);
  CHECK(calls(srkn11b, 10) == 11 * 10 + 1);
}

TEST_CASE("symmetric: a step there and back is none, to rounding") {
  const auto check = [](auto scheme, auto force, auto start) {
    auto y = start;
    PhiStepper stepper{y, force, scheme};
    problems::step(stepper, y, 0.0, 0.2);
    CHECK(distance(y, start) > 0.01);
    problems::step(stepper, y, 0.2, -0.2);
    // Up to 24 kicks and drifts, a rounding of numbers near 1 each, magnified by less than 2.
    CHECK(distance(y, start) <= 24 * 2 * 1.2e-16);
  };
  check(srkn6b, Anharmonic{}, six());
  check(srkn11b, Anharmonic{}, six());
}

TEST_CASE("symplectic: the energy of five thousand orbits doesn't drift") {
  const problems::Kepler kepler{0.2};
  const auto energy = [](const auto& y) { return y.v.squaredNorm() / 2 - 1 / y.r.norm(); };
  auto y = kepler.start();
  PhiStepper stepper{y, kepler, srkn11b};
  // Not a whole number of steps an orbit: else the phase at which they fall would creep.
  const double h = problems::Kepler::period / 12.37, before = energy(y);
  double early = 0, all = 0;
  for (int n = 0; n < 500 * 12; ++n) {  // a tenth of them
    problems::step(stepper, y, n * h, h);
    all = std::max(all, std::abs(energy(y) / before - 1));
    if (n < 50 * 12) early = all;
  }
  CHECK(all <= 1.1 * early);
  CHECK(all <= 3e-4);
}

TEST_CASE("a force that isn't finite leaves the state as it was") {
  const auto check = [](auto scheme, auto force) {
    auto y = six();
    const auto before = states::numbers(y);
    PhiStepper stepper{y, force, scheme};
    const StepReport report = stepper.step(y, 0.0, 0.2);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK(states::same_bits(states::numbers(y), before));
  };
  check(srkn11b, LateTrouble{});
}
