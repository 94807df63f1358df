#include <phistep/phistep.hpp>

#include <cmath>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "contract/states.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using problems::distance;
using states::numbers, states::same_bits;
using Flow = problems::ForcedFlow<>;
using Swing = problems::ForcedMotion<>;
using Vec = Eigen::Vector2d;

namespace step_doubling_cases {

inline const auto yes = [](const auto&...) { return true; };
inline const auto no = [](const auto&...) { return false; };

template <class S>
bool same_trace(const Trace<S>& a, const Trace<S>& b) {
  // What later steps read: `start` and `before` where they are known.
  if (a.knows_start != b.knows_start || a.dt_before != b.dt_before) return false;
  if (a.knows_start && !same_bits(numbers(a.start), numbers(b.start))) return false;
  return a.dt_before == 0 || same_bits(numbers(a.before), numbers(b.before));
}

/// A force with memory: it remembers the path length, and is weakened by it. It throws, or is no number, at a given call.
struct Worn {
  struct Memory {
    double length = 0;
    Vec last = Vec::Zero();
  };
  static constexpr bool uses_time = false;
  int* calls;
  int* fatal;
  bool* throws;
  void begin(double, double, const auto& y, Memory& m) const { m.last = y.y; }
  void add(double, const auto& y, const Memory& m, auto& out) const {
    if (++*calls == *fatal) {
      if (*throws) throw std::runtime_error("worn out");
      out.rate[0] += std::nan("");
    }
    out.rate += -y.y / (1 + m.length + (y.y - m.last).norm());
  }
  void commit(double, const auto& y, Memory& m) const {
    m.length += (y.y - m.last).norm();
    m.last = y.y;
  }
};

void check_halves(auto scheme, double divisor) {
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
}

void check_rejections(auto start, auto psi, auto scheme, auto mass_spec) {
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
}

void check_failures(auto scheme) {
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
}

}  // namespace step_doubling_cases

using namespace step_doubling_cases;

#if PHISTEP_QUICK

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

TEST_CASE("a step between neighbouring times is taken back, too, where the force throws at its end") {
  Vec y{1, 0.3};
  const double end = std::nextafter(0.5, 1.0);
  PhiStepper stepper{y, [end](const Vec& x, double t) -> Vec { return t < end ? -x : throw std::runtime_error("end"); },
                     midpoint};
  Run run{stepper, y, {0, 1}, tolerance{.rtol = 1e-4}, at_times({0.5, end}, [](double, const Vec&) {})};
  while (run.time() < 0.5) REQUIRE(run.advance());
  const Vec before = y;
  CHECK_THROWS_AS(run.advance(), std::runtime_error);
  CHECK(run.time() == 0.5);
  CHECK(same_bits(numbers(y), numbers(before)));
}

#elif PHISTEP_FULL
// Step doubling by every scheme.

TEST_CASE("the result is that of two half steps, to the bit; the error is a third of the difference at order 2") {
  check_halves(midpoint, 3), check_halves(phi_stage(0.7), 1), check_halves(rannacher, 3);
}

TEST_CASE("after a rejection everything is as it was, to the bit, and the next steps are those of one never tried") {
  check_rejections(Flow::exact(0.1), Flow{}, midpoint, capacity(Flow::capacity));
  check_rejections(Flow::exact(0.1), Flow{}, trapezoidal, capacity(Flow::capacity));
  check_rejections(Flow::exact(0.1), Flow{}, rannacher(2), capacity(Flow::capacity));
  check_rejections(Swing::exact(0.1), Swing{}, velocity_verlet, mass(Swing::mass));
  check_rejections(Swing::exact(0.1), Swing{}, symplectic_euler, mass(Swing::mass));
}

TEST_CASE("a force with memory: failure and exception at every call leave state, history and trace as they were") {
  check_failures(midpoint), check_failures(trapezoidal), check_failures(forward_euler), check_failures(rannacher);
}

#endif
