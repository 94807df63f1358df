
#include "run/stepper/step_doubling_cases.hpp"

using namespace step_doubling_cases;

TEST_CASE("the result is that of two half steps, to the bit; the error is a third of the difference at order 2") {
  check_halves(midpoint, 3), check_halves(rannacher, 3);
}

TEST_CASE("after a rejection everything is as it was, to the bit, and the next steps are those of one never tried") {
  check_rejections(Flow::exact(0.1), Flow{}, midpoint, capacity(Flow::capacity));
  check_rejections(Flow::exact(0.1), Flow{}, rannacher(2), capacity(Flow::capacity));
}

TEST_CASE("explicit steppers: bit for bit") {
  const auto spring = [](const Vec& r) -> Vec { return -9 * r - r.squaredNorm() * r; };
  Motion<Vec> y{Vec(1, 0), Vec(0, 2)}, z = y;
  PhiStepper stepper{y, spring, symplectic_euler}, untried{z, spring, symplectic_euler};
  StepDoubling<decltype(stepper), Motion<Vec>> doubling, other;
  doubling.resize(y), other.resize(z);
  Trace<Motion<Vec>> trace, past;
  trace.resize(y), past.resize(z);
  for (int n = 0; n < 20; ++n) {
    CHECK_FALSE(doubling.attempt(stepper, y, 0, 0.1, Origin::unknown, trace, no));
    REQUIRE(doubling.attempt(stepper, y, 0, 0.02, Origin::unknown, trace, yes));
    REQUIRE(other.attempt(untried, z, 0, 0.02, Origin::unknown, past, yes));
    REQUIRE(same_bits(numbers(y), numbers(z)));
    REQUIRE(same_trace(trace, past));
  }
}

TEST_CASE("a force with memory: failure and exception at every call leave state, history and trace as they were") {
  check_failures(midpoint);
}

TEST_CASE("Rannacher's start is not used up by steps that were taken back") {
  Vec y = Flow::exact(0);
  PhiStepper stepper{y, Flow{}, rannacher(2), capacity(Flow::capacity)};
  StepDoubling<decltype(stepper), Vec> doubling;
  doubling.resize(y);
  Trace<Vec> trace;
  trace.resize(y);
  for (int n = 0; n < 5; ++n) CHECK_FALSE(doubling.attempt(stepper, y, 0, 0.1, Origin::unknown, trace, no));
  CHECK(stepper.checkpoint().progress == 0);
  REQUIRE(doubling.attempt(stepper, y, 0, 0.1, Origin::unknown, trace, yes));
  CHECK(stepper.checkpoint().progress == 2);
}

TEST_CASE("three steps a try, no more") {
  Vec y = Flow::exact(0);
  PhiStepper stepper{y, Flow{}, midpoint, capacity(Flow::capacity)};
  StepDoubling<decltype(stepper), Vec> doubling;
  doubling.resize(y);
  Trace<Vec> trace;
  trace.resize(y);
  REQUIRE(doubling.attempt(stepper, y, 0, 0.1, Origin::unknown, trace, yes));
  CHECK(stepper.statistics().steps == 3);
  CHECK(stepper.statistics().failed_steps == 0);
}
