// iteration_control, every scheme. The quick half is iteration_control.test.cpp.
#include "control/iteration_control_cases.hpp"

using namespace iteration_cases;

TEST_CASE("an oscillator settles at K_d ± 1 iterations, at every φ, from far too short and from far too long") {
  // Its contraction is φ²ω²Δt² exactly.
  const auto settle = [](auto scheme, double first, int desired, double tol) {
    Motion<Two> y{Two(1, 0), Two(0, 20)};  // round in a circle: no phase at which everything passes through zero
    PhiStepper stepper{y, Pull{400}, scheme, fixed_point({.rtol = tol, .depth = 0})};
    Run run{stepper, y, {0.0, 1e6}, iteration_control{.first_step = first, .desired = desired}};
    std::vector<int> iterations;
    for (int n = 0; n < 200; ++n) {
      REQUIRE(run.advance());
      iterations.push_back(stepper.history().iterations);
    }
    int worst = 0;
    for (std::size_t n = 100; n < 200; ++n) worst = std::max(worst, std::abs(iterations[n] - desired));
    return worst;
  };
  for (const double first : {1e-6, 1e-2, 0.3, 50.0})
    for (const int desired : {5, 6, 8})
      for (const double tol : {0.0, 1e-6}) {
        CAPTURE(first, desired, tol);
        CHECK(settle(trapezoidal, first, desired, tol) <= 1);
        CHECK(settle(backward_euler, first, desired, tol) <= 1);
      }
}

TEST_CASE("smaller_of: neither the error nor the iterations are more than allowed") {
  // Slow and weak, then stiff: error rules the first, iterations the second.
  const auto run = [](double omega_squared, const auto& control) {
    Swing y{One(1), One(0)};
    PhiStepper stepper{y, Pull{omega_squared}, trapezoidal, fixed_point({.depth = 0})};
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
  Swing y{One(1), One(0)};
  PhiStepper stepper{y, Pull{1}, trapezoidal};
  CHECK(integrate(stepper, y, {0, 5}, smaller_of(tight, {.max_steps = 3})).outcome == Outcome::too_many_steps);
}

TEST_CASE("an explicit scheme has no iterations: the step grows to its bound") {
  Swing y{One(1), One(0)};
  PhiStepper stepper{y, Pull{1}, velocity_verlet};
  const RunReport report = integrate(stepper, y, {0, 10}, iteration_control{.first_step = 1e-3, .max_step = 0.1});
  REQUIRE(report);
  CHECK(report.largest_dt <= 0.1);
  CHECK(report.limits.most().by == LimitedBy::max_step);
}

TEST_CASE("a start at which the iteration diverges recovers, and the run says what held it") {
  Swing y{One(1), One(0)};
  PhiStepper stepper{y, Pull{1e4}, trapezoidal, fixed_point({.depth = 0})};
  const RunReport report = integrate(stepper, y, {0, 1}, iteration_control{.first_step = 0.5});
  REQUIRE(report);
  CHECK(report.t == 1);
  CHECK(report.statistics.failed_steps >= 1);
  CHECK(report.largest_dt < 0.02);  // φωΔt < 1
  CHECK(report.limits.most().by == LimitedBy::iterations);
  CHECK(y.r.squaredNorm() + y.v.squaredNorm() / 1e4 == Approx(1).epsilon(0.05));  // φ = ½ keeps the energy
}
