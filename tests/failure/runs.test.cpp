// Controlled runs that can't go on, or are not meant to: each a clear outcome, none a hang, nothing lost.
#include "failure/runs_cases.hpp"

using namespace runs_cases;

TEST_CASE("t1 = t0: shown, done, unless the observer has had enough") {
  Vec y(1, 2);
  PhiStepper stepper{y, decay, trapezoidal};
  int shown = 0;
  const RunReport report = integrate(stepper, y, {2, 2}, tolerance{}, Look([&](double, const Vec&) { ++shown; }));
  CHECK(report);
  CHECK(report.t == 2);
  CHECK(shown == 1);
  CHECK(report.statistics == Statistics{});
}

TEST_CASE("options that can't work are refused before anything happens") {
  std::string option;
  const auto refused = [&option](const tolerance& control, TimeSpan<double> span = {0, 1}) {
    const RunReport report = refusal(control, span);
    option = report.refused != nullptr ? report.refused : "";
    CHECK(option.empty() == (report.outcome != Outcome::invalid_tolerance));
    CHECK_THAT(report.message(), contains(option));
    return report.outcome;
  };
  using enum Outcome;
  for (const double rtol : {0.0, -1e-4, NaN, inf, 1.0, 1e-15, 1e-300})
    CHECK(refused(tolerance{.rtol = rtol}) == invalid_tolerance);
  CHECK(option == "rtol, which is below rounding");
  for (const double atol : {-1.0, NaN, inf}) CHECK(refused(tolerance{.atol = atol}) == invalid_tolerance);
  CHECK_THAT(option, contains("atol"));
  CHECK(refused(tolerance{.atol = {1.0, 1.0}}) == invalid_tolerance);
  CHECK(refused(tolerance{.atol = Eigen::VectorXd::Ones(3).eval()}) == invalid_tolerance);
  for (const double bad : {-1.0, NaN}) {
    CHECK(refused(tolerance{.first_step = bad}) == invalid_tolerance);
    CHECK(refused(tolerance{.min_step = bad}) == invalid_tolerance);
    CHECK(refused(tolerance{.max_step = bad}) == invalid_tolerance);
  }
  CHECK(option == "max_step");
  CHECK(refused(tolerance{.max_step = 0.0}) == invalid_tolerance);
  CHECK(refused(tolerance{.min_step = 0.1, .max_step = 0.05}) == invalid_tolerance);
  CHECK(option == "min_step, which exceeds max_step");
  CHECK(refused(tolerance{.max_steps = -1}) == invalid_tolerance);
  CHECK(option == "max_steps");
  for (const double bad : {inf, -inf}) CHECK(refused(tolerance{}, {0, bad}) == invalid_step);
  Vec y(1, 2);
  PhiStepper stepper{y, decay, trapezoidal};
  CHECK(integrate(stepper, y, {0, NaN}, tolerance{}).outcome == invalid_step);
  CHECK(integrate(stepper, y, {NaN, 0}, tolerance{}).outcome == invalid_step);
}

TEST_CASE("a start that is no number, a force that is none there") {
  Vec y(1, NaN);
  PhiStepper stepper{y, decay, trapezoidal};
  CHECK(integrate(stepper, y, {0, 1}, tolerance{}).outcome == Outcome::non_finite_state);
  Vec z(1, 2);
  PhiStepper nowhere{z, Psi([](const Vec&, double) -> Vec { return Vec(NaN, 0); }), trapezoidal};
  const RunReport report = integrate(nowhere, z, {0, 1}, tolerance{});
  CHECK(report.outcome == Outcome::non_finite_force);
  CHECK_THAT(report.message(), contains("force is not finite"));
  CHECK(z == Vec(1, 2));
}

TEST_CASE("bounds on steps and tries hold") {
  const auto run = [](const tolerance& control, auto scheme) {
    Vec y = decayed(0);
    PhiStepper stepper{y, decay, scheme};
    std::vector<double> times;
    const RunReport report =
        integrate(stepper, y, {0, 5}, control, Look([&](double t, const Vec&) { times.push_back(t); }));
    for (std::size_t n = 0; n + 1 < times.size(); ++n) CHECK(times[n + 1] - times[n] <= control.max_step * (1 + 1e-14));
    return std::pair{report, times};
  };
  const auto [capped, at] = run({.rtol = 1e-2, .max_step = 0.125}, trapezoidal);
  CHECK(capped);
  CHECK(at.size() >= 41);
  CHECK(capped.largest_dt <= 0.125);
  CHECK(capped.limits.most().by == LimitedBy::max_step);
  const auto [split, ends] =
      run({.rtol = 1e-2, .max_step = 5 / 40.005}, trapezoidal);  // no last step of 1.005 times that
  CHECK(split);

  const auto [given, times] = run({.rtol = 1e-2, .first_step = 1e-5}, trapezoidal);
  CHECK(given);
  CHECK(times[1] == 1e-5);
  const auto [huge, big] = run({.rtol = 1e-2, .first_step = 1e300}, trapezoidal);
  CHECK(huge);

  const auto [tired, few] = run({.rtol = 1e-6, .max_steps = 7}, trapezoidal);
  CHECK(tired.outcome == Outcome::too_many_steps);
  CHECK(few.size() <= 8);
  CHECK(few.size() >= 2);
  const auto [none, start] = run({.rtol = 1e-6, .max_steps = 0}, trapezoidal);
  CHECK(none.outcome == Outcome::too_many_steps);
  CHECK(start.size() == 1);

  // A smallest step that the tolerance can't live with ends the run; one that it can is kept.
  const auto [floored, f] = run({.rtol = 1e-6, .min_step = 0.5}, trapezoidal);
  CHECK(floored.outcome == Outcome::step_too_small);
  CHECK_THAT(floored.message(), contains("smallest step"));
  const auto [kept, k] = run({.rtol = 1e-2, .first_step = 1e-5, .min_step = 1e-3}, trapezoidal);
  CHECK(kept);
  for (std::size_t n = 0; n + 2 < k.size(); ++n) CHECK(k[n + 1] - k[n] >= 0.999e-3);
}

TEST_CASE("through a pole there is no way: the run says so, the last good state stays") {
  meet_pole("trapezoidal", trapezoidal);
}

TEST_CASE("a pole that lies at t = 0, where no step is too small for the clock") {
  Vec y(1, 0.5);
  PhiStepper stepper{y, square, trapezoidal};
  const RunReport report = integrate(stepper, y, {-1, 2}, tolerance{.rtol = 1e-4, .max_steps = 200'000});
  CAPTURE(report.message(), report.t);
  CHECK_FALSE(report);
  CHECK(report.outcome != Outcome::too_many_steps);
  CHECK(report.outcome != Outcome::invalid_step);
}

TEST_CASE("a force that is no number from a time on: named, and the run ends before it") {
  CHECK(meet_nan("trapezoidal", trapezoidal) == LimitedBy::not_finite);
}

TEST_CASE("a force that throws, at whatever call: the last good step stands, and the run can go on") {
  check_throws(Flow::exact(0), flow, trapezoidal, Flow::exact, tolerance{.rtol = 1e-3});
}

TEST_CASE("an observer that throws leaves a run that can go on") {
  Vec y = decayed(0);
  PhiStepper stepper{y, decay, trapezoidal};
  int calls = 0;
  const Look observer = [&](double, const Vec&) {
    if (++calls % 5 == 1) throw std::runtime_error("look away");
  };
  Run run{stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-4}, observer};
  int thrown = 0;
  for (bool more = true; more;) {
    try {
      more = run.advance();
    } catch (const std::runtime_error&) {
      ++thrown;
    }
    REQUIRE(thrown < 1000);
  }
  CHECK(run.report());
  CHECK(thrown > 3);
  CHECK(distance(y, decayed(1)) <= 1e-3);
}

TEST_CASE("a jump in the force is passed, in short steps") { pass_jump("trapezoidal", trapezoidal); }

TEST_CASE("a step that the clock can't show any shorter is not tried again") {
  // Two ticks of the clock, and far too long for the tolerance: the stop is within its rounding, whatever dt is wanted.
  int calls = 0;
  const auto counted = [&calls](const Eigen::VectorXd& y) -> Eigen::VectorXd {
    ++calls;
    return -y;
  };
  const auto ends = [&](auto scheme, double length) {
    CAPTURE(length);
    calls = 0;
    Eigen::VectorXd y = Eigen::VectorXd::Ones(2);
    phistep::PhiStepper stepper{y, counted, scheme};
    const auto report = phistep::integrate(stepper, y, {1e16, 1e16 + length}, phistep::tolerance{.rtol = 1e-6});
    CHECK(report.outcome == phistep::Outcome::step_too_small);
    CHECK(calls < 200);
    CHECK((report.statistics.steps > 0 || y == Eigen::VectorXd::Ones(2)));
  };
  for (const double length : {2.0, 4.0, -2.0}) ends(phistep::tsit5, length), ends(phistep::rodas5p, length);
  ends(phistep::trapezoidal, 4.0);
}
