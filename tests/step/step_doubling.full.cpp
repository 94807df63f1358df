// Step doubling by every scheme; the quick half is step_doubling.test.cpp.
#include "step/step_doubling_cases.hpp"

using namespace step_doubling_cases;

TEST_CASE("the result is that of two half steps, to the bit; the error is a third of the difference at order 2") {
  const auto check = [](auto scheme, double divisor) {
    Vec y = Flow::exact(0.2), twice = y, once = y;
    const auto make = [&](const Vec& s) { return PhiStepper{s, Flow{}, scheme, capacity(Flow::capacity)}; };
    auto stepper = make(y), two = make(twice), one = make(once);
    StepDoubling<decltype(stepper), Vec> doubling;
    doubling.resize(y);
    Trace<Vec> trace;
    trace.resize(y);
    REQUIRE(doubling.attempt(stepper, y, 0.2, 0.1, Origin::unknown, trace, yes));
    REQUIRE(two.step(twice, 0.2, 0.05));
    REQUIRE(two.step(twice, 0.2 + 0.05, 0.05));
    REQUIRE(one.step(once, 0.2, 0.1));
    // Newton's matrix is that of the whole step at first: both iterate to rounding.
    CHECK(distance(y, twice) <= 1e-14);
    CHECK(distance(trace.error, Vec((once - twice) / divisor)) <= 1e-14);
    CHECK(trace.has_error);
  };
  check(midpoint, 3), check(phi_stage(0.7), 1), check(rannacher, 3);
}

TEST_CASE("after a rejection everything is as it was, to the bit, and the next steps are those of one never tried") {
  const auto check = [](auto start, auto psi, auto scheme, auto mass_spec) {
    using S = decltype(start);
    S y = start, z = start;
    PhiStepper stepper{y, psi, scheme, mass_spec}, untried{z, psi, scheme, mass_spec};
    StepDoubling<decltype(stepper), S> doubling, other;
    doubling.resize(y), other.resize(z);
    Trace<S> trace, past;
    trace.resize(y), past.resize(z);
    double t = 0.1;
    for (int n = 0; n < 6; ++n) {
      const double dt = 0.05 / (1 + n % 3);
      const S before = y;
      CHECK(doubling.attempt(stepper, y, t, 2 * dt, Origin::unknown, trace, no).outcome() == Outcome::error_too_large);
      CHECK(same_bits(numbers(y), numbers(before)));
      REQUIRE(doubling.attempt(stepper, y, t, dt, Origin::unknown, trace, yes));
      REQUIRE(other.attempt(untried, z, t, dt, Origin::unknown, past, yes));
      trace.advance(), past.advance();
      CHECK(distance(y, z) <= 1e-13);  // Newton's matrices differ, its results to rounding
      CHECK(trace.knows_start == past.knows_start);
      CHECK(trace.dt_before == past.dt_before);
      t += dt;
    }
  };
  check(Flow::exact(0.1), Flow{}, midpoint, capacity(Flow::capacity));
  check(Flow::exact(0.1), Flow{}, trapezoidal, capacity(Flow::capacity));
  check(Flow::exact(0.1), Flow{}, rannacher(2), capacity(Flow::capacity));
  check(Swing::exact(0.1), Swing{}, velocity_verlet, mass(Swing::mass));
  check(Swing::exact(0.1), Swing{}, symplectic_euler, mass(Swing::mass));
}

TEST_CASE("a force with memory: failure and exception at every call leave state, history and trace as they were") {
  const auto check = [](auto scheme) {
    int calls = 0, fatal = 0;
    bool throws = false;
    Vec y(1, -0.5), reference = y;
    PhiStepper stepper{y, Worn{&calls, &fatal, &throws}, scheme};
    StepDoubling<decltype(stepper), Vec> doubling;
    doubling.resize(y);
    Trace<Vec> trace;
    trace.resize(y);
    for (int n = 0; n < 3; ++n) {
      REQUIRE(doubling.attempt(stepper, y, 0.1 * n, 0.1, Origin::unknown, trace, yes));
      trace.advance();
    }
    // What the next step makes of it, and with how many calls.
    auto twin = stepper;
    reference = y;
    auto twin_trace = trace;
    calls = 0;
    REQUIRE(doubling.attempt(twin, reference, 0.3, 0.1, Origin::unknown, twin_trace, yes));
    const int all = calls;
    const Vec before = y;
    const double length = std::get<0>(std::tie(stepper.memory())).length;
    for (const bool exception : {false, true})
      for (int k = 1; k <= all + 1; ++k) {
        CAPTURE(k, exception);
        calls = 0, fatal = k, throws = exception;
        bool done = false;
        try {
          done = static_cast<bool>(doubling.attempt(stepper, y, 0.3, 0.1, Origin::unknown, trace, no));
        } catch (const std::runtime_error&) {
        }
        CHECK_FALSE(done);
        CHECK(same_bits(y, before));
        CHECK(stepper.memory().length == length);
        fatal = 0;
        auto again = stepper;
        Vec z = y;
        auto z_trace = trace;
        REQUIRE(doubling.attempt(again, z, 0.3, 0.1, Origin::unknown, z_trace, yes));
        CHECK(distance(z, reference) <= 1e-13);
        CHECK(again.memory().length == Approx(twin.memory().length).epsilon(1e-13));
      }
  };
  check(midpoint), check(trapezoidal), check(forward_euler), check(rannacher);
}
