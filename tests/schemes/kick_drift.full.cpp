// SRKN6b and SRKN11b: long runs, masses, float, restarts; the quick half is kick_drift.test.cpp.
#include "contract/restart.hpp"

#include "schemes/kick_drift_cases.hpp"

using namespace kick_drift_cases;

TEST_CASE("symplectic: the energy of five thousand orbits doesn't drift") {
  const problems::Kepler kepler{0.2};
  const auto energy = [](const auto& y) { return y.v.squaredNorm() / 2 - 1 / y.r.norm(); };
  const auto worst = [&](auto scheme, int steps) {  // in the first tenth, and over all
    auto y = kepler.start();
    PhiStepper stepper{y, kepler, scheme};
    // Not a whole number of steps an orbit: else the phase at which they fall would creep.
    const double h = problems::Kepler::period / (steps + 0.37), before = energy(y);
    double early = 0, all = 0;
    for (int n = 0; n < 5000 * steps; ++n) {
      problems::step(stepper, y, n * h, h);
      all = std::max(all, std::abs(energy(y) / before - 1));
      if (n < 500 * steps) early = all;
    }
    CHECK(all <= 1.1 * early);
    return all;
  };
  CHECK(worst(srkn6b, 20) <= 3e-4);
  CHECK(worst(srkn11b, 12) <= 3e-4);
}

TEST_CASE("a force that isn't finite leaves the state as it was") {
  const auto check = [](auto scheme, auto force) {
    auto y = six();
    const auto before = restart::bytes(y);
    PhiStepper stepper{y, force, scheme};
    const StepReport report = stepper.step(y, 0.0, 0.2);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK(restart::bytes(y) == before);
  };
  check(srkn11b, LateTrouble{});
}

TEST_CASE("masses: none, one, one a component, a matrix") {
  const auto go = [](auto... m) { return march(PhiStepper{six(), Anharmonic{}, srkn11b, m...}, six(), 0.0, 2.0, 20); };
  const auto one = go(), two = go(mass(2.0));
  CHECK(distance(one, go(mass(Eigen::MatrixXd(Eigen::MatrixXd::Identity(6, 6))))) <= 1e-13);
  CHECK(distance(two, go(mass(Vec(Vec::Constant(6, 2.0))))) <= 1e-13);
  CHECK(distance(two, go(mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(6, 6))))) <= 1e-13);
  CHECK(distance(one, two) > 0.1);
}

TEST_CASE("float reaches its rounding") {
  CHECK(error_at_end<float>(srkn6b, 100) <= 100 * 1.2e-7 * 10);
  CHECK(error_at_end<float>(srkn11b, 20) <= 100 * 1.2e-7 * 10);
}

TEST_CASE("a restart gives the same bits") {
  const auto steps = [](auto force, auto scheme) {
    return [=](const auto& y) { return PhiStepper{y, force, scheme}; };
  };
  restart::check({0.05, false}, six, steps(Anharmonic{}, srkn6b));
  restart::check({0.05}, six, steps(Anharmonic{}, srkn11b));
}
