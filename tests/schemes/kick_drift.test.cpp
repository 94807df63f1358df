// SRKN6b and SRKN11b: order, counts, symmetry, energy over long times, failures, restarts.
#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>

#include "accuracy/observed_order.hpp"
#include "contract/states.hpp"
#include "problems/driven_motion.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#if PHISTEP_FULL
#include "contract/restart.hpp"
#endif

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::error_at_end;
using problems::march;
using Vec = Eigen::VectorXd;

namespace kick_drift_cases {

struct Anharmonic : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(auto, const auto& y, auto& out) const { out.force -= 2 * y.r + y.r.cwiseProduct(y.r).cwiseProduct(y.r); }
};
struct LateTrouble : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = true;
  void add(double t, const auto& y, auto& out) const {
    out.force -= y.r;
    if (t > 0.15) out.force[3] = std::numeric_limits<double>::quiet_NaN();
  }
};
inline Motion<Vec> six() {
  return {Eigen::Map<const Vec>(states::positions.data(), 6), Eigen::Map<const Vec>(states::velocities.data(), 6)};
}

}  // namespace kick_drift_cases

using namespace kick_drift_cases;

#if PHISTEP_QUICK

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

#elif PHISTEP_FULL
// SRKN6b and SRKN11b: long runs, masses, float, restarts.

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

#endif
