// run, every scheme: times, stops, counts. The quick half is run.test.cpp.
#include "run/run_cases.hpp"

using namespace run_cases;

TEST_CASE("every scheme ends at t1 itself, near the truth, forward and backward") {
  for_each_scheme([](const char* name, auto scheme) {
    for (const double t1 : {1.7, -1.1}) {
      CAPTURE(name, t1);
      Vec y = Flow::exact(0.3);
      PhiStepper stepper{y, Flow{}, scheme, capacity(Flow::capacity)};
      const double rtol = 1e-4;
      // Backward the problem grows by e^{-λt}, λ ≥ −5 at M = 1.5 and 1.4 time units: errors by 1e2.
      const RunReport report = integrate(stepper, y, {0.3, t1}, tolerance{.rtol = rtol});
      REQUIRE(report);
      CHECK(report.t == t1);
      CHECK(distance(y, Flow::exact(t1)) <= (t1 > 0 ? 10 : 1000) * rtol);
    }
  });
  const auto motion = [](auto scheme) {
    for (const double t1 : {2.3, -1.1}) {
      Moving y = Swing::exact(0.3);
      PhiStepper stepper{y, Swing{}, scheme, mass(Swing::mass)};
      const RunReport report = integrate(stepper, y, {0.3, t1}, tolerance{.rtol = 1e-4});
      REQUIRE(report);
      CHECK(report.t == t1);
      CHECK(distance(y, Swing::exact(t1)) <= (t1 > 0 ? 1e-3 : 1e-2));
    }
  };
  motion(velocity_verlet), motion(trapezoidal), motion(symplectic_euler), motion(tr_bdf2), motion(backward_euler);
}

TEST_CASE("given times are hit to the last bit: random ones, forward and backward, fixed and controlled") {
  const std::vector<double> times = some_times();
  const auto check = [&](double t0, double t1, auto scheme, const auto& control) {
    std::vector<double> seen;
    Vec y = Flow::exact(t0);
    PhiStepper stepper{y, Flow{}, scheme, capacity(Flow::capacity)};
    double worst = 0;
    const RunReport report = integrate(stepper, y, {t0, t1}, control, at_times(times, [&](double t, const Vec& now) {
                                         seen.push_back(t);
                                         worst = std::max(worst, distance(now, Flow::exact(t)));
                                       }));
    REQUIRE(report);
    CHECK(report.t == t1);
    CHECK(seen == met_of(times, t0, t1));
    CHECK(worst <= 0.01);
  };
  check(-1.5, 2.5, trapezoidal, fixed(0.1));
  check(-1.5, 2.5, trapezoidal, tolerance{.rtol = 1e-4});
  check(-1.5, 2.5, tr_bdf2, tolerance{.rtol = 1e-4});
  check(-1.5, 2.5, midpoint, tolerance{.rtol = 1e-4});
  check(-1.5, 2.5, backward_euler, tolerance{.rtol = 1e-3});
  check(0.7, -0.4, trapezoidal, fixed(0.05));
  check(0.7, -0.4, trapezoidal, tolerance{.rtol = 1e-4});
  check(0.7, -0.4, rannacher, tolerance{.rtol = 1e-4});
}

TEST_CASE("stops between grid points leave the grid of a fixed run where it is") {
  Vec y = Flow::exact(0);
  PhiStepper stepper{y, Flow{}, trapezoidal, capacity(Flow::capacity)};
  std::vector<double> seen;
  const RunReport report = integrate(stepper, y, {0, 1}, fixed(0.1), at_times(stops_between, [](double, const Vec&) {}),
                                     [&](double t, const Vec&) { seen.push_back(t); });
  check_stops_between(report, seen);
}

TEST_CASE("a stop on the grid, but for rounding, costs no factorization") {
  const auto run = [](auto&&... observers) {
    Vec y(1, 2);
    PhiStepper stepper{y, decay, trapezoidal};
    return integrate(stepper, y, {0, 10}, fixed(0.1), observers...).statistics;
  };
  std::vector<double> times;
  for (int k = 1; k < 100; ++k) times.push_back(k / 10.0);  // k·0.1 differs in half of them
  int seen = 0;
  const Statistics with = run(at_times(times, [&](double, const Vec&) { ++seen; })), without = run();
  CHECK(seen == 99);
  CHECK(with.steps == without.steps);
  CHECK(with.factorizations == without.factorizations);
}

TEST_CASE("stops a rounding apart cost nothing in accuracy") {
  // Slopes by the scheme's own relation, (y⁺ − b)/φΔt, are noise after a step of 1e-16.
  const auto run = [](auto scheme, auto&&... observers) {
    Moving y = Swing::exact(0);
    PhiStepper stepper{y, Swing{}, scheme, mass(Swing::mass)};
    const RunReport report = integrate(stepper, y, {0, 2}, tolerance{.rtol = 1e-5}, observers...);
    CHECK(report);
    return distance(y, Swing::exact(2));
  };
  const auto check = [&](auto scheme) {
    const double undisturbed = run(scheme),
                 disturbed = run(scheme, at_times(close_times(), [](double, const auto&) {}));
    CAPTURE(undisturbed, disturbed);
    CHECK(disturbed <= 10 * undisturbed + 1e-5);
  };
  check(trapezoidal), check(backward_euler), check(tr_bdf2), check(velocity_verlet), check(phi(0.7)), check(midpoint);
}

TEST_CASE("steps and rejections of the report are those of the run, whoever estimates") {
  for_each_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    Vec y = Flow::exact(0);
    PhiStepper stepper{y, Flow{}, scheme, capacity(Flow::capacity)};
    Run run{stepper, y, {0.0, 2.0}, tolerance{.rtol = 1e-3, .first_step = 1}};
    std::int64_t steps = 0;
    while (run.advance()) ++steps;
    const RunReport report = run.report();
    CHECK(report.statistics.steps == steps);
    CHECK(report.statistics.rejections >= 1);
    CHECK(report.limits.steps() == steps);
  });
}
