// runs: the full product and what is dear to compile. The quick half is runs.test.cpp.
#include "failure/runs_cases.hpp"

using namespace runs_cases;

TEST_CASE("t1 = t0: shown, done, unless the observer has had enough") {
  Vec y(1, 2);
  PhiStepper stepper{y, decay, trapezoidal};
  CHECK(integrate(stepper, y, {2, 2}, tolerance{}, [](double, const Vec&) { return false; }).outcome ==
        Outcome::stopped_by_observer);
}

TEST_CASE("options that can't work are refused before anything happens") {
  const auto refused = [](const auto& control) { return refusal(control).outcome; };
  using enum Outcome;
  for (const double bad : {-1.0, NaN}) {
    CHECK(refused(iteration_control{.first_step = bad}) == invalid_tolerance);
    CHECK(refused(iteration_control{.first_step = 0.1, .order = bad}) == invalid_tolerance);
    CHECK(refused(iteration_control{.first_step = 0.1, .min_step = bad}) == invalid_tolerance);
    CHECK(refused(iteration_control{.first_step = 0.1, .max_step = bad}) == invalid_tolerance);
    CHECK(refused(smaller_of(tolerance{}, iteration_control{.first_step = bad})) == invalid_tolerance);
    CHECK(refused(smaller_of(tolerance{}, iteration_control{.order = bad})) == invalid_tolerance);
    CHECK(refused(smaller_of(tolerance{}, iteration_control{.min_step = bad})) == invalid_tolerance);
    CHECK(refused(smaller_of(tolerance{}, iteration_control{.max_step = bad})) == invalid_tolerance);
    CHECK(refused(smaller_of(tolerance{.max_step = bad}, iteration_control{.max_step = 1})) == invalid_tolerance);
  }
  CHECK(refused(iteration_control{}) == invalid_tolerance);
  CHECK(refused(iteration_control{.first_step = 0.1, .desired = 0}) == invalid_tolerance);
  CHECK(refused(smaller_of(tolerance{}, iteration_control{.desired = 0})) == invalid_tolerance);
}

TEST_CASE("a start that is no number, a force that is none there") {
  Vec y(1, NaN);
  PhiStepper stepper{y, decay, trapezoidal};
  CHECK(integrate(stepper, y, {0, 1}, iteration_control{.first_step = 0.1}).outcome == Outcome::non_finite_state);
}

TEST_CASE("through a pole there is no way: the run says so, the last good state stays") { for_each_scheme(meet_pole); }

TEST_CASE("a force that is no number from a time on: named, and the run ends before it") { for_each_scheme(meet_nan); }

TEST_CASE("a force that throws, at whatever call: the last good step stands, and the run can go on") {
  const auto swing = [](const Vec& r, const Vec& v, double t) -> Vec { return Swing{}(r, v, t) / Swing::mass; };
  const tolerance control{.rtol = 1e-3};
  check_throws(Flow::exact(0), flow, trapezoidal, Flow::exact, control);
  check_throws(Flow::exact(0), flow, tr_bdf2, Flow::exact, control);
  check_throws(Flow::exact(0), flow, midpoint, Flow::exact, control);
  check_throws(Swing::exact(0), swing, velocity_verlet, Swing::exact, control);
  check_throws(Swing::exact(0), swing, backward_euler, Swing::exact, control);
  check_throws(Flow::exact(0), flow, trapezoidal, Flow::exact, fixed(0.02));
  check_throws(Flow::exact(0), flow, trapezoidal, Flow::exact, iteration_control{.first_step = 0.01, .max_step = 0.02});
}

TEST_CASE("a jump in the force is passed, in short steps") { for_each_scheme(pass_jump); }
