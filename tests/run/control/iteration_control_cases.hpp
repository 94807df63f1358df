#pragma once

// What iteration_control.test.cpp and its full half share.

#include <phistep/phistep.hpp>
#include <phistep/run/control/iteration_control.hpp>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support/catch.hpp"

namespace iteration_cases {

using namespace phistep;
using One = Eigen::Matrix<double, 1, 1>;
using Swing = Motion<One>;
using Two = Eigen::Vector2d;

inline Failure contracting(int corrections, double q) {
  Failure history;
  for (int k = 0; k < corrections; ++k) history.record(0.3 * std::pow(q, k));
  return history;
}

/// m r'' = −ω² r, by plain iteration.
struct Pull {
  double omega_squared;
  auto operator()(const auto& r) const { return (-omega_squared * r).eval(); }
};

/// How far from `desired` the iterations of the last 100 of 200 steps get, for ω² = 400.
int off_desired(const auto& force, auto scheme, double first, int desired, double tol) {
  Motion<Two> y{Two(1, 0), Two(0, 20)};  // round in a circle: no phase at which everything passes through zero
  PhiStepper stepper{y, force, scheme, fixed_point({.rtol = tol, .depth = 0})};
  Run run{stepper, y, {0.0, 1e6}, iteration_control{.first_step = first, .desired = desired}};
  std::vector<int> iterations;
  for (int n = 0; n < 200; ++n) {
    REQUIRE(run.advance());
    iterations.push_back(stepper.history().iterations);
  }
  int worst = 0;
  for (std::size_t n = 100; n < 200; ++n) worst = std::max(worst, std::abs(iterations[n] - desired));
  return worst;
}

template <class State>
void check_smaller_of(const State& start, const auto& pull, auto scheme) {
  // Slow and weak, then stiff: error rules the first, iterations the second.
  const auto run = [&](double omega_squared, const auto& control) {
    State y = start;
    PhiStepper stepper{y, pull(omega_squared), scheme, fixed_point({.depth = 0})};
    const RunReport report = integrate(stepper, y, {0, 5}, control);
    CHECK(report);
    return report;
  };
  const tolerance tight{.rtol = 1e-5}, loose{.rtol = 0.3, .atol = 10.0};
  const iteration_control few{.first_step = 1e-3, .desired = 3}, many{.first_step = 1e-3, .desired = 20};
  const RunReport by_error = run(1, smaller_of(tight, many)), alone = run(1, tight);
  CHECK(by_error.limits.most().by == LimitedBy::error);
  CHECK(by_error.statistics.steps ==
        Approx(static_cast<double>(alone.statistics.steps)).epsilon(0.2));  // the dead band
  const RunReport by_iterations = run(1, smaller_of(loose, few));
  CHECK(by_iterations.limits.most().by == LimitedBy::iterations);
  CHECK(by_iterations.statistics.steps > 2 * run(1, loose).statistics.steps);
  // Its own bounds count, too.
  CHECK(run(1, smaller_of(loose, {.first_step = 1e-3, .max_step = 0.01})).largest_dt <= 0.01);
}

template <class State>
void check_growth(State y, const auto& force) {
  PhiStepper stepper{y, force, velocity_verlet};
  const RunReport report = integrate(stepper, y, {0, 10}, iteration_control{.first_step = 1e-3, .max_step = 0.1});
  REQUIRE(report);
  CHECK(report.largest_dt <= 0.1);
  CHECK(report.limits.most().by == LimitedBy::max_step);
}

template <class State>
void check_recovery(State y, const auto& force, auto scheme) {
  PhiStepper stepper{y, force, scheme, fixed_point({.depth = 0})};
  const RunReport report = integrate(stepper, y, {0, 1}, iteration_control{.first_step = 0.5});
  REQUIRE(report);
  CHECK(report.t == 1);
  CHECK(report.statistics.failed_steps >= 1);
  CHECK(report.largest_dt < 0.02);  // φωΔt < 1
  CHECK(report.limits.most().by == LimitedBy::iterations);
  CHECK(y.r.squaredNorm() + y.v.squaredNorm() / 1e4 == Approx(1).epsilon(0.05));  // φ = ½ keeps the energy
}

}  // namespace iteration_cases
