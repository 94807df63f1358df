// Runs of fixed steps: times, counts, ends, observers.
#include <phistep/integrate.hpp>
#include <phistep/phistep.hpp>

#include <array>
#include <cmath>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "support/catch.hpp"
#if PHISTEP_QUICK
#include "support/shared_force.hpp"
#endif

namespace integrate_cases {

using namespace phistep;
using Vec = Eigen::Vector2d;
using Y = Motion<Vec>;

inline const auto spring = [](const Vec& r) -> Vec { return -4 * r; };
inline Y start() { return {Vec(1, 0), Vec(0, 0.5)}; }
inline const auto decay = [](const Vec& y, double t) -> Vec { return (-y.array() + t).matrix(); };

}  // namespace integrate_cases

using namespace integrate_cases;

#if PHISTEP_QUICK

namespace {

// One stepper of each kind and one type of observer, so that a run is compiled once for each.
using Pull = shared_force::OfStateAndTime<Vec>;
using Push = shared_force::OfState<Vec>;
const Pull fading = decay;
const Push pull = spring;
using Implicit = decltype(PhiStepper{std::declval<Vec&>(), fading, phi(0.5)});
using Verlet = decltype(PhiStepper{std::declval<Y&>(), pull, velocity_verlet});
using Look = std::function<void(double, const Vec&)>;
using Watch = std::function<bool(double, Y&)>;

RunReport go(
    Implicit& stepper, Vec& y, TimeSpan<double> span, FixedStep control, const Look& look = [](double, const Vec&) {}) {
  return integrate(stepper, y, span, control, look);
}
RunReport go(
    Verlet& stepper, Y& y, TimeSpan<double> span, FixedStep control,
    const Watch& watch = [](double, Y&) { return true; }) {
  return integrate(stepper, y, span, control, watch);
}

}  // namespace

TEST_CASE("ends exactly at t1, and shows t0 + n dt") {
  Vec y(1, 2);
  PhiStepper stepper{y, fading, phi(0.5)};
  std::vector<double> times;
  const RunReport report = go(stepper, y, {0.3, 7.3}, fixed(0.1), [&](double t, const Vec&) { times.push_back(t); });
  REQUIRE(report);
  CHECK(report.t == 7.3);
  CHECK(report.outcome == Outcome::success);
  REQUIRE(times.size() == 71);
  for (std::size_t n = 0; n < 70; ++n) CHECK(times[n] == 0.3 + static_cast<double>(n) * 0.1);
  CHECK(times.back() == 7.3);
  CHECK(report.statistics.steps == 70);
}

TEST_CASE("the force sees the same times") {
  Y y = start();
  std::vector<double> times;
  PhiStepper stepper{y, Push{[&](const Vec& r) -> Vec { return -4 * r; }}, velocity_verlet};
  REQUIRE(go(stepper, y, {0, 1}, fixed(0.3), [&](double t, Y&) { return times.push_back(t), true; }));
  CHECK(times == std::vector<double>{0, 0.3, 0.6, 3 * 0.3, 1});
}

TEST_CASE("is the same as the loop by hand, to the bit") {
  Y a = start(), b = start();
  PhiStepper one{a, pull, velocity_verlet}, two{b, pull, velocity_verlet};
  REQUIRE(go(one, a, {0, 2}, fixed(0.02)));
  for (int n = 0; n < 100; ++n) REQUIRE(two.step(b, n * 0.02, 0.02));
  CHECK((a.r == b.r && a.v == b.v));
}

namespace {
/// How far a body of speed 1 comes in frames of a given length, relative to the time that they take, and less 1.
template <class Scalar>
double lost(Scalar t0, double dt, double frame, int frames, auto&&... watch) {
  using One = Eigen::Matrix<Scalar, 1, 1>;
  Motion<One> y{One::Zero(), One::Ones()};
  PhiStepper stepper{y, [](const One&) -> One { return One::Zero(); }, symplectic_euler};
  const auto at = [&](int k) { return static_cast<Scalar>(static_cast<double>(t0) + k * frame); };
  // What is asked for is what the clock can tell: the sum of frames as they are.
  double time = 0;
  for (int k = 0; k < frames; ++k) {
    const RunReport report = integrate(stepper, y, {at(k), at(k + 1)}, fixed(dt), watch...);
    REQUIRE(report);
    time += static_cast<double>(at(k + 1) - at(k));
  }
  return std::abs(static_cast<double>(y.r[0]) / time - 1);
}
}  // namespace

TEST_CASE("far from t = 0 no motion is lost, in frames of any length, nor between given times") {
  CHECK(lost<double>(0, 1e-3, 1.0 / 60, 60) <= 1e-13);
  CHECK(lost<float>(1000, 1e-3, 1.0 / 60, 60) <= 2e-5);
  CHECK(lost<double>(1.7e9, 1e-5, 1.45e-5, 100) <= 1e-13);
  CHECK(lost<double>(1.7e9, 1e-5, 1.01e-5, 100) <= 1e-13);
  CHECK(lost<double>(1e15, 0.3, 1, 50) <= 1e-13);
  CHECK(lost<double>(-1e15, 0.3, 1, 50) <= 1e-13);
  std::vector<double> times;
  for (int k = 1; k < 300; ++k) times.push_back(1.7e9 + k * 0.71e-5);
  CHECK(lost<double>(1.7e9, 1e-5, 1e-3, 2, at_times(times, [](double, auto&) {})) <= 1e-12);
}

TEST_CASE("a short last step lands on t1") {
  Vec y(1, 2), z(1, 2);
  PhiStepper stepper{y, fading, phi(0.5)}, by_hand{z, fading, phi(0.5)};
  REQUIRE(go(stepper, y, {0, 1}, fixed(0.4)));
  REQUIRE(by_hand.step(z, 0, 0.4));
  REQUIRE(by_hand.step(z, 0.4, 0.4));
  REQUIRE(by_hand.step(z, 0.8, 1 - 0.8));
  CHECK((y - z).norm() <= 1e-15);
}

TEST_CASE("a whole number of steps costs one factorization of a linear scene") {
  Vec y(1, 2);
  PhiStepper stepper{y, fading, phi(0.5)};
  const RunReport report = go(stepper, y, {0, 10}, fixed(0.1));  // 10/0.1 is not a whole number in bits
  CHECK(report.statistics.factorizations == 1);
  CHECK(report.statistics.jacobians == 1);
}

TEST_CASE(
    "frames of whole steps cost one factorization, too, though their lengths differ by the rounding of their times") {
  for (const double t0 : {0.0, 5.0, 1000.0}) {
    Vec y(1, 2);
    PhiStepper stepper{y, [](const Vec& x) -> Vec { return -x.array().cube(); }, phi(0.5)};
    for (int k = 0; k < 60; ++k) REQUIRE(integrate(stepper, y, {t0 + k / 60.0, t0 + (k + 1) / 60.0}, fixed(1.0 / 240)));
    CHECK(stepper.statistics().steps == 240);
    CHECK(stepper.statistics().factorizations == stepper.statistics().jacobians);
  }
}

TEST_CASE("… and of a linear scene, whose answer is as if all steps had one length") {
  for (const double t0 : {0.0, 5.0, 1000.0}) {
    Vec y(1, 2), z = y;
    const auto decay_alone = affine([](const Vec& x) -> Vec { return -2 * x; });
    PhiStepper stepper{y, decay_alone, phi(0.5)}, by_hand{z, decay_alone, phi(0.5)};
    for (int k = 0; k < 60; ++k) REQUIRE(integrate(stepper, y, {t0 + k / 60.0, t0 + (k + 1) / 60.0}, fixed(1.0 / 240)));
    for (int k = 0; k < 240; ++k) REQUIRE(by_hand.step(z, 0, 1.0 / 240));
    CHECK(stepper.statistics().steps == 240);
    CHECK(stepper.statistics().factorizations == 1);
    CHECK((y - z).norm() <= 1e-15 * (60 + 240 * t0));  // the lengths of the frames are known to a rounding of t
  }
}

TEST_CASE("forth and back returns to the start") {
  Y y = start();
  PhiStepper stepper{y, pull, velocity_verlet};
  REQUIRE(go(stepper, y, {1, 3}, fixed(0.05)));
  CHECK((y.r - start().r).norm() > 0.1);
  const RunReport back = go(stepper, y, {3, 1}, fixed(0.05));
  REQUIRE(back);
  CHECK(back.t == 1);
  CHECK((y.r - start().r).norm() <= 1e-13);
  CHECK((y.v - start().v).norm() <= 1e-13);
}

TEST_CASE("t0 = t1 shows the start and does nothing") {
  Y y = start();
  PhiStepper stepper{y, pull, velocity_verlet};
  int shown = 0;
  const RunReport report = go(stepper, y, {2, 2}, fixed(0.1), [&](double, Y&) { return ++shown, true; });
  CHECK(report);
  CHECK(report.t == 2);
  CHECK(shown == 1);
  CHECK(report.statistics == Statistics{});
  CHECK(y.r == start().r);
}

TEST_CASE("a span or dt that is no number is refused before anything happens") {
  for (const auto& [t0, t1, dt] :
       {std::array{std::nan(""), 1.0, 0.1}, std::array{0.0, std::nan(""), 0.1}, std::array{0.0, 1.0, std::nan("")},
        std::array{0.0, 1.0, 0.0}, std::array{0.0, HUGE_VAL, 0.1}}) {
    Y y = start();
    PhiStepper stepper{y, pull, velocity_verlet};
    int shown = 0;
    const RunReport report = go(stepper, y, {t0, t1}, fixed(dt), [&](double, Y&) { return ++shown, true; });
    CHECK(report.outcome == Outcome::invalid_step);
    CHECK_THAT(report.message(), contains("not a usable number") && contains("Try"));
    CHECK(shown == 0);
    CHECK(report.statistics.force_calls == 0);
    CHECK((y.r == start().r && y.v == start().v));
  }
}

TEST_CASE("more steps than allowed are refused before the first") {
  Y y = start();
  PhiStepper stepper{y, pull, velocity_verlet};
  const RunReport report = go(stepper, y, {0, 1}, fixed(1e-3, {.max_steps = 999}));
  CHECK(report.outcome == Outcome::too_many_steps);
  CHECK(report.statistics.steps == 0);
  CHECK_THAT(report.message(), contains("max_steps"));
  CHECK(go(stepper, y, {0, 1}, fixed(1e-3, {.max_steps = 1000})));
}

TEST_CASE("t + dt = t ends the run, it does not hang") {
  Y y = start();
  PhiStepper stepper{y, pull, velocity_verlet};
  const RunReport report = go(stepper, y, {1e20, 1e20 + 1e6}, fixed(1.0));
  CHECK(report.outcome == Outcome::step_too_small);
  CHECK(report.t == 1e20);
  CHECK(y.r == start().r);
}

TEST_CASE("a step that fails ends the run at the last good state") {
  Y y = start(), last = y;
  PhiStepper stepper{
      y, Push{[&](const Vec& r) -> Vec { return r[0] < 0.6 ? Vec(Vec::Constant(std::nan(""))) : Vec(-4 * r); }},
      velocity_verlet};
  int steps = -1;
  const RunReport report = go(stepper, y, {0, 1}, fixed(0.1), [&](double, Y& s) { return last = s, ++steps, true; });
  CHECK_FALSE(report);
  CHECK(report.outcome == Outcome::non_finite_force);
  CHECK(report.t == Approx(0.1 * steps));
  CHECK(report.statistics.steps == steps);
  CHECK(report.statistics.failed_steps == 1);
  CHECK((y.r == last.r && y.v == last.v));
  CHECK_THAT(report.message(), contains("force is not finite") && contains("dt = 0.1"));
}

TEST_CASE("an exception of the force or of an observer passes through") {
  Y y = start();
  PhiStepper stepper{y, pull, velocity_verlet};
  const auto thrower = [](double t, const Y&) -> bool { return t > 0.25 ? throw std::runtime_error("enough") : true; };
  CHECK_THROWS_WITH(static_cast<void>(go(stepper, y, {0, 1}, fixed(0.1), thrower)), "enough");
  CHECK(stepper.statistics().steps == 3);
}

TEST_CASE("an observer that returns false stops the run, at the start too") {
  Y y = start();
  PhiStepper stepper{y, pull, velocity_verlet};
  const RunReport report = go(stepper, y, {0, 1}, fixed(0.1), [](double t, const Y&) { return t < 0.35; });
  CHECK(report.outcome == Outcome::stopped_by_observer);
  CHECK_FALSE(report);
  CHECK(report.t == 4 * 0.1);
  CHECK(report.statistics.steps == 4);
  const RunReport at_once = go(stepper, y, {0, 1}, fixed(0.1), [](double, const Y&) { return false; });
  CHECK(at_once.outcome == Outcome::stopped_by_observer);
  CHECK(at_once.t == 0);
  CHECK(at_once.statistics.steps == 0);
}

TEST_CASE("several observers, in order; one that stops hides the step from the rest") {
  Y y = start();
  PhiStepper stepper{y, pull, velocity_verlet};
  std::string order;
  const RunReport report = integrate(
      stepper, y, {0, 1}, fixed(0.5), [&](double, const Y&) { order += 'a'; },
      [&](double t, const Y&) {
        order += 'b';
        return t < 0.4;
      },
      [&](double, const Y&) { order += 'c'; });
  CHECK(order == "abcab");
  CHECK(report.outcome == Outcome::stopped_by_observer);
}

TEST_CASE("a recorder keeps the run, by itself and through every") {
  Y y = start();
  PhiStepper stepper{y, pull, velocity_verlet};
  Recorder<Y> all, some;
  REQUIRE(integrate(stepper, y, {0, 1}, fixed(0.1), all, every(0.5, std::ref(some))));
  CHECK(all.size() == 11);
  CHECK(all.times()[10] == 1);
  CHECK(all.states().col(10).head(2) == y.r);
  CHECK(all.states().col(10).tail(2) == y.v);
  CHECK(some.size() == 3);
  CHECK(some.states().col(1) == all.states().col(5));
}

TEST_CASE("observers may edit the state, however they get at it") {
  const auto run = [](int how) {
    Y y{Vec(1, 0.3), Vec(0, -1)};
    const auto bounce = [](Y& s) {
      if (s.r[1] < 0) s.r[1] = -s.r[1], s.v[1] = -s.v[1];
    };
    PhiStepper stepper{y, pull, velocity_verlet};
    const Watch edit = [&](double, Y&s) { return bounce(s), true; },
                by_name = [&](double, Y&) { return bounce(y), true; };
    if (how == 0) {
      for (int n = 0; n < 50; ++n) {
        PhiStepper fresh{y, pull, velocity_verlet};
        REQUIRE(fresh.step(y, n * 0.05, 0.05));
        bounce(y);
      }
    } else if (how == 2) {
      REQUIRE(integrate(stepper, y, {0, 2.5}, fixed(0.05), every(0.05, edit)));
    } else {
      REQUIRE(go(stepper, y, {0, 2.5}, fixed(0.05), how == 1 ? edit : by_name));
    }
    return y;
  };
  const Y expected = run(0);
  for (const int how : {1, 2, 3}) {
    const Y got = run(how);
    CAPTURE(how);
    CHECK((got.r - expected.r).norm() <= 1e-12);
    CHECK((got.v - expected.v).norm() <= 1e-12);
  }
}

TEST_CASE("an editing observer may be generic") {
  Y y = start();
  PhiStepper stepper{y, pull, velocity_verlet};
  REQUIRE(integrate(stepper, y, {0, 1}, fixed(0.1), [](double, auto& s) { s.v.setZero(); }));
  CHECK(y.v == Vec(0, 0));
}

TEST_CASE("statistics are of this run alone") {
  Y y = start();
  PhiStepper stepper{y, pull, velocity_verlet};
  REQUIRE(go(stepper, y, {0, 1}, fixed(0.1)));
  const RunReport second = go(stepper, y, {1, 2}, fixed(0.1));
  CHECK(second.statistics.steps == 10);
  CHECK(stepper.statistics().steps == 20);
}

TEST_CASE("a report prints outcome, time and counts") {
  Vec y(1, 2);
  PhiStepper stepper{y, fading, phi(0.5)};
  std::ostringstream out;
  out << go(stepper, y, {0, 1}, fixed(0.1));
  CHECK_THAT(out.str(), contains("success") && contains("reached t           1") &&
                            contains("steps               10") && contains("force calls") &&
                            contains("factorizations      1"));
}

#elif PHISTEP_FULL
// integrate, every scheme.

TEST_CASE("forth and back returns to the start") {
  Y y = start();
  PhiStepper stepper{y, spring, midpoint};
  REQUIRE(integrate(stepper, y, {1, 3}, fixed(0.05)));
  CHECK((y.r - start().r).norm() > 0.1);
  const RunReport back = integrate(stepper, y, {3, 1}, fixed(0.05));
  REQUIRE(back);
  CHECK(back.t == 1);
  CHECK((y.r - start().r).norm() <= 1e-13);
  CHECK((y.v - start().v).norm() <= 1e-13);
}

// A floor that reflects: the run must go on from the edited state, in every scheme that carries something over.

TEST_CASE("observers may edit the state, however they get at it") {
  const auto run = [](auto scheme, int how) {
    Y y{Vec(1, 0.3), Vec(0, -1)};
    const auto bounce = [](Y& s) {
      if (s.r[1] < 0) s.r[1] = -s.r[1], s.v[1] = -s.v[1];
    };
    PhiStepper stepper{y, spring, scheme};
    if (how == 0) {
      for (int n = 0; n < 50; ++n) {
        PhiStepper fresh{y, spring, scheme};
        REQUIRE(fresh.step(y, n * 0.05, 0.05));
        bounce(y);
      }
    } else if (how == 1) {
      REQUIRE(integrate(stepper, y, {0, 2.5}, fixed(0.05), [&](double, Y& s) { bounce(s); }));
    } else if (how == 2) {
      REQUIRE(integrate(stepper, y, {0, 2.5}, fixed(0.05), every(0.05, [&](double, Y& s) { bounce(s); })));
    } else {
      REQUIRE(integrate(stepper, y, {0, 2.5}, fixed(0.05), [&](double, const Y&) { bounce(y); }));
    }
    return y;
  };
  const auto check = [&](auto scheme) {
    const Y expected = run(scheme, 0);
    for (const int how : {1, 2, 3}) {
      const Y got = run(scheme, how);
      CAPTURE(how);
      CHECK((got.r - expected.r).norm() <= 1e-12);
      CHECK((got.v - expected.v).norm() <= 1e-12);
    }
  };
  check(velocity_verlet), check(phi(0.7)), check(trapezoidal);
}

TEST_CASE("a view of the user's own array is integrated in place") {
  double memory[2] = {1, 2};
  Eigen::Map<Vec> y(memory);
  Vec z(1, 2);
  PhiStepper stepper{y, decay, trapezoidal};
  PhiStepper owning{z, decay, trapezoidal};
  REQUIRE(integrate(stepper, y, {0, 1}, fixed(0.1)));
  REQUIRE(integrate(owning, z, {0, 1}, fixed(0.1)));
  CHECK(memory[0] == z[0]);
  CHECK(memory[1] == z[1]);
}

// A first program.

TEST_CASE("the 15-line program") {
  auto pull = [](const Vec& r) -> Vec { return -400.0 * r; };
  phistep::Motion state{Vec{1, 0}, Vec{0, 0}};
  phistep::PhiStepper stepper{state, pull, phistep::trapezoidal, phistep::mass(2.0)};
  for (int n = 0; n < 1000; ++n)
    if (auto step = stepper.step(state, 0.01 * n, 0.01); !step) FAIL(step.message());
  // φ = ½ keeps the energy ½·2·v² + ½·400·r² = 200; its angle a step is 2 atan(ωΔt/2), ω² = 200.
  CHECK(state.v.squaredNorm() + 200 * state.r.squaredNorm() == Approx(200).epsilon(1e-12));
  CHECK(state.r[0] == Approx(std::cos(2000 * std::atan(std::sqrt(200.0) * 0.005))).epsilon(1e-10));
}

TEST_CASE("the force sees the same times") {
  Vec y(1, 2);
  std::vector<double> times;
  const auto force = [&times](const Vec& x, double t) -> Vec {
    times.push_back(t);
    return -x;
  };
  PhiStepper stepper{y, force, forward_euler};
  REQUIRE(integrate(stepper, y, {0, 1}, fixed(0.3)));
  CHECK(times[0] <= 1e-15);  // just behind the start, where a load may jump
  times[0] = 0;
  CHECK(times == std::vector<double>{0, 0.3, 0.6, 3 * 0.3});
}

TEST_CASE("a step that fails ends the run at the last good state") {
  Vec y(1, 2);
  PhiStepper stepper{
      y, [](const Vec& x, double t) -> Vec { return t > 0.45 ? Vec(Vec::Constant(std::nan(""))) : Vec(-x); },
      forward_euler};
  Recorder<Vec> recorder;
  const RunReport report = integrate(stepper, y, {0, 1}, fixed(0.1), recorder);
  CHECK_FALSE(report);
  CHECK(report.outcome == Outcome::non_finite_force);
  CHECK(report.t == Approx(0.5));
  CHECK(report.statistics.steps == 5);
  CHECK(report.statistics.failed_steps == 1);
  CHECK(y == recorder.states().rightCols(1));
  CHECK_THAT(report.message(), contains("force is not finite") && contains("t = 0.5") && contains("dt = 0.1"));
}

TEST_CASE("a report prints outcome, time and counts") {
  Y y = start();
  PhiStepper stepper{y, spring, trapezoidal};
  std::ostringstream out;
  out << integrate(stepper, y, {0, 1}, fixed(0.1));
  CHECK_THAT(out.str(), contains("success") && contains("reached t           1") &&
                            contains("steps               10") && contains("force calls") &&
                            contains("factorizations      1"));
}

#endif
