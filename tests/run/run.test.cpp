// Runs controlled by their error, and runs step by step: what users and their observers may do to them.
#include <algorithm>
#include <memory>
#include <utility>

#include "run/run_cases.hpp"
#if PHISTEP_QUICK
#include "support/shared_force.hpp"
#endif

using namespace run_cases;

#if PHISTEP_QUICK

using Pull = shared_force::OfStateAndTime<Vec>;
using Push = shared_force::OfMotionAndTime<Vec>;

namespace {

template <class S>
using Edit = std::function<void(double, S&)>;
template <class S>
using Look = std::function<void(double, const S&)>;

/// A stepper and its run, whatever their types: what is checked is compiled once.
template <class F>
struct Ride {
  virtual ~Ride() = default;
  virtual bool advance() = 0;
  virtual RunReport finish() = 0;
  [[nodiscard]] virtual RunReport report() const = 0;
  [[nodiscard]] virtual double time() const = 0;
  virtual F& force() = 0;
};
/// What a ride may be given: stops, and who looks.
template <class S>
struct Watch {
  std::vector<double> times;
  Edit<S> edit = [](double, S&) {};
  Look<S> look = [](double, const S&) {};
};
template <class F, class Stepper, class S, class Control>
struct RideOf final : Ride<F> {
  Stepper stepper;
  AtTimes<Edit<S>> at;
  Look<S> look;
  Run<Stepper, S, Control, AtTimes<Edit<S>>&, Look<S>&> run;

  RideOf(Stepper made, S& y, TimeSpan<double> span, const Control& control, Watch<S> watch)
      : stepper{std::move(made)},
        at{TimeList(watch.times), std::move(watch.edit)},
        look{std::move(watch.look)},
        run{stepper, y, span, control, at, look} {}
  bool advance() override { return run.advance(); }
  RunReport finish() override { return run.finish(); }
  [[nodiscard]] RunReport report() const override { return run.report(); }
  [[nodiscard]] double time() const override { return run.time(); }
  F& force() override { return stepper.force(); }
};
template <class F>
using AnyRide = std::unique_ptr<Ride<F>>;

template <class S, class F, class Mass, class Control>
AnyRide<F> ride(S& y, const F& force, auto scheme, const Mass& m, TimeSpan<double> span, const Control& control,
                Watch<S> watch) {
  using Stepper = decltype(PhiStepper{y, force, scheme, m});
  return std::make_unique<RideOf<F, Stepper, S, Control>>(Stepper{y, force, scheme, m}, y, span, control,
                                                          std::move(watch));
}

/// The schemes of these tests: phi(…) is one type for every φ.
struct Scheme {
  const char* name;
  std::function<AnyRide<Pull>(Vec& y, const Pull&, double m, TimeSpan<double>, const tolerance&, Watch<Vec>)> ride;
};
template <class Any>
Scheme scheme(const char* name, Any any) {
  return {name, [any](Vec& y, const Pull& force, double m, TimeSpan<double> span, const tolerance& control,
                      Watch<Vec> watch) { return ride(y, force, any, capacity(m), span, control, std::move(watch)); }};
}
const std::vector<Scheme>& schemes() {
  static const std::vector<Scheme> all{scheme("phi(0.7)", phi(0.7)),
                                       scheme("phi(1)", phi(1.0)),
                                       scheme("phi(0.5)", phi(0.5)),
                                       scheme("tr_bdf2", tr_bdf2),
                                       scheme("forward_euler", forward_euler),
                                       scheme("rannacher", rannacher),
                                       scheme("generalized_alpha(0.5)", generalized_alpha(0.5))};
  return all;
}
const Scheme& trapezoidal_rule() { return schemes()[2]; }
const Scheme& euler() { return schemes()[4]; }

AnyRide<Pull> fixed_ride(Vec& y, const Pull& force, double m, TimeSpan<double> span, double dt, Watch<Vec> watch) {
  return ride(y, force, phi(0.5), capacity(m), span, fixed(dt), std::move(watch));
}
AnyRide<Push> verlet_ride(Moving& y, const Push& force, double m, TimeSpan<double> span, const tolerance& control,
                          Watch<Moving> watch) {
  return ride(y, force, velocity_verlet, mass(m), span, control, std::move(watch));
}
const Pull flow = Flow{}, fading = [](const Vec&y, double) -> Vec { return Vec(-y[0], -2 * y[1]); };
const Push swing = Swing{};

}  // namespace

TEST_CASE("every scheme ends at t1 itself, near the truth, forward and backward") {
  const double rtol = 1e-4;
  for (const double t1 : {1.7, -1.1}) {
    for (const Scheme& each : schemes()) {
      CAPTURE(each.name, t1);
      Vec y = Flow::exact(0.3);
      const RunReport report = each.ride(y, flow, Flow::capacity, {0.3, t1}, {.rtol = rtol}, {})->finish();
      REQUIRE(report);
      CHECK(report.t == t1);
      // Backward the problem grows by e^{-λt}, λ ≥ −5 at M = 1.5 and 1.4 time units: errors by 1e2.
      CHECK(distance(y, Flow::exact(t1)) <= (t1 > 0 ? 10 : 1000) * rtol);
    }
    Moving y = Swing::exact(0.3);
    const RunReport report = verlet_ride(y, swing, Swing::mass, {0.3, t1}, {.rtol = rtol}, {})->finish();
    REQUIRE(report);
    CHECK(report.t == t1);
    CHECK(distance(y, Swing::exact(t1)) <= (t1 > 0 ? 1e-3 : 1e-2));
  }
}

TEST_CASE("no step is longer than max_step, the last one neither") {
  for (const double t1 : {1.0, 1.0005, 0.1005, -1.0005}) {
    Vec y(1, 1);
    const RunReport report =
        euler()
            .ride(y, fading, 1, {0, t1}, {.rtol = 0.5, .atol = 1e3, .first_step = 0.1, .max_step = 0.1}, {})
            ->finish();
    REQUIRE(report);
    CHECK(report.largest_dt <= 0.1);
  }
}

TEST_CASE("given times are hit to the last bit: random ones, forward and backward, fixed and controlled") {
  const std::vector<double> times = some_times();
  const auto check = [&](TimeSpan<double> span, double rtol, double dt) {
    std::vector<double> seen;
    double worst = 0;
    const Watch<Vec> watch{times, [&](double t, Vec& now) {
                             seen.push_back(t);
                             worst = std::max(worst, distance(now, Flow::exact(t)));
                           }};
    Vec y = Flow::exact(span.t0);
    const auto run = dt > 0 ? fixed_ride(y, flow, Flow::capacity, span, dt, watch)
                            : trapezoidal_rule().ride(y, flow, Flow::capacity, span, {.rtol = rtol}, watch);
    const RunReport report = run->finish();
    REQUIRE(report);
    CHECK(report.t == span.t1);
    CHECK(seen == met_of(times, span.t0, span.t1));
    CHECK(worst <= 0.01);
  };
  check({-1.5, 2.5}, 0, 0.1);
  check({-1.5, 2.5}, 1e-4, 0);
  check({0.7, -0.4}, 0, 0.05);
  check({0.7, -0.4}, 1e-4, 0);
}

TEST_CASE("stops between grid points leave the grid of a fixed run where it is") {
  Vec y = Flow::exact(0);
  std::vector<double> seen;
  const RunReport report =
      fixed_ride(y, flow, Flow::capacity, {0, 1}, 0.1,
                 {.times = stops_between, .look = [&](double t, const Vec&) { seen.push_back(t); }})
          ->finish();
  check_stops_between(report, seen);
}

TEST_CASE("a stop on the grid, but for rounding, costs no factorization") {
  const auto run = [](Watch<Vec> watch) {
    Vec y(1, 2);
    return fixed_ride(y, fading, 1, {0, 10}, 0.1, std::move(watch))->finish().statistics;
  };
  std::vector<double> times;
  for (int k = 1; k < 100; ++k) times.push_back(k / 10.0);  // k·0.1 differs in half of them
  int seen = 0;
  const Statistics with = run({times, [&](double, Vec&) { ++seen; }}), without = run({});
  CHECK(seen == 99);
  CHECK(with.steps == without.steps);
  CHECK(with.factorizations == without.factorizations);
}

TEST_CASE("stops a rounding apart cost nothing in accuracy") {
  const std::vector<double> times = close_times();
  for (const Scheme& each : schemes()) {
    const auto run = [&](const std::vector<double>& stops) {
      Vec y = Flow::exact(0);
      CHECK(each.ride(y, flow, Flow::capacity, {0, 2}, {.rtol = 1e-5}, {.times = stops})->finish());
      return distance(y, Flow::exact(2));
    };
    const double undisturbed = run({}), disturbed = run(times);
    CAPTURE(each.name, undisturbed, disturbed);
    CHECK(disturbed <= 10 * undisturbed + 1e-5);
  }
}

namespace {

/// How far a run whose state is edited at t = 1 is from one that starts there, and the second run's own error.
template <class S, class Force>
void compare_edits(const std::function<AnyRide<Force>(S&, TimeSpan<double>, const tolerance&, Watch<S>)>& go,
                   const S& start, const std::function<void(S&)>& edit) {
  const tolerance control{.rtol = 1e-5};
  S by_observer = start, by_caller = start, by_finish = start, afresh = start;
  REQUIRE(go(by_observer, {0, 2}, control, {{1.0}, [&](double, S& y) { edit(y); }})->finish());
  {
    const auto run = go(by_caller, {0, 2}, control, {.times = {1.0}});
    while (run->advance())
      if (run->time() == 1) edit(by_caller);
    REQUIRE(run->report());
  }
  {
    const auto run = go(by_finish, {0, 2}, {.rtol = 1e-5, .first_step = 0.125 / 64, .max_step = 0.0625}, {});
    for (int n = 0; n < 30; ++n) REQUIRE(run->advance());
    const double t = run->time();
    edit(by_finish);
    S same = by_finish;
    REQUIRE(run->finish());
    REQUIRE(go(same, {t, 2}, control, {})->finish());
    CHECK(distance(by_finish, same) <= 1e-4);
  }
  REQUIRE(go(afresh, {0, 1}, control, {})->finish());
  edit(afresh);
  REQUIRE(go(afresh, {1, 2}, control, {})->finish());
  // Both are within about 10·rtol of the truth (tests/tolerance); the edits are of order one.
  CHECK(distance(by_observer, afresh) <= 2e-4);
  CHECK(distance(by_caller, afresh) <= 2e-4);
}

}  // namespace

TEST_CASE("after an edit nothing stale is used") {
  const Pull stiff = [](const Vec& y, double t) -> Vec { return Vec(-40 * (y[0] - std::cos(t)), y[0] - y[1] * y[1]); };
  const Push driven = [](const Vec& r, const Vec& v, double t) -> Vec {
    return Vec(-9 * r - 0.2 * v + Vec(std::sin(t), 0));
  };
  for (const Scheme& each : schemes()) {
    if (&each == &euler() || &each == &schemes()[1]) continue;
    CAPTURE(each.name);
    compare_edits<Vec, Pull>([&](Vec& y, TimeSpan<double> span, const tolerance& control,
                                 Watch<Vec> watch) { return each.ride(y, stiff, 1, span, control, std::move(watch)); },
                             Vec(1, 0.5), [](Vec& y) { y = Vec(3, -0.2); });
  }
  compare_edits<Moving, Push>(
      [&](Moving& y, TimeSpan<double> span, const tolerance& control, Watch<Moving> watch) {
        return verlet_ride(y, driven, 1, span, control, std::move(watch));
      },
      Moving{Vec(1, 0), Vec(0, 1)}, [](Moving& y) { y.r[0] += 1, y.v = -y.v + Vec(0, 2); });
}

TEST_CASE("an edit costs the force call that makes the slope anew, and no more") {
  const auto calls = [](const std::function<void(Vec&)>& edit) {
    Vec y(1, 2);
    const auto run = euler().ride(y, fading, 1, {0, 1}, {.rtol = 1e-3, .atol = 1e-3}, {});
    while (run->advance()) edit(y);
    return run->report().statistics;
  };
  // Two for the first length, one at the end of each try; one at the start of each step whose start isn't known.
  const Statistics kept = calls([](Vec&) {}), edited = calls([](Vec&y) { y[0] = std::nextafter(y[0], 0); });
  CHECK(kept.force_calls == 2 + kept.steps + kept.rejections + 1);
  CHECK(edited.force_calls == 2 + edited.steps + edited.rejections + edited.steps);
}

TEST_CASE("a force that is changed between steps is asked anew") {
  const auto pull_to = [](double to) -> Pull {
    return [to](const Vec& y, double) -> Vec { return Vec(to - y[0], to - y[1]); };
  };
  for (const Scheme& each : schemes()) {
    CAPTURE(each.name);
    Vec y(1, 1);
    Ride<Pull>* seen = nullptr;
    const auto run = each.ride(y, pull_to(1), 1, {0, 2}, {.rtol = 1e-4, .max_step = 0.5},
                               {{1.0}, [&](double, Vec&) { seen->force() = pull_to(-5); }});
    seen = run.get();
    REQUIRE(run->finish());
    CHECK(y[0] == Approx(-5 + 6 * std::exp(-1)).epsilon(1e-3));
  }
}

TEST_CASE("a state that grows while the run goes on") {
  const shared_force::OfState<Eigen::VectorXd> fall = [](const Eigen::VectorXd& r) -> Eigen::VectorXd { return -r; };
  check_growing(velocity_verlet, fall);
}

TEST_CASE("observers that stop a controlled run, of both kinds, in order") {
  Vec y = decayed(0);
  PhiStepper stepper{y, fading, phi(0.5), capacity(1.0)};
  check_observers_that_stop(stepper, y);
}

TEST_CASE("an observer of steps sees their ends before any edit, wherever it stands in the list") {
  Vec y = decayed(0);
  PhiStepper stepper{y, fading, phi(0.5), capacity(1.0)};
  Vec last = y;
  double jumped = 0;
  REQUIRE(integrate(
      stepper, y, {0, 1}, fixed(0.25), [](double, Vec& state) { state *= 2; },
      [&](const CompletedStep<Vec>& step) {
        CHECK(step.start() == 2 * last);
        CHECK(step.end().norm() < step.start().norm());  // it fades: not doubled
        jumped += step.end().norm();
        last = step.end();
      },
      sampled(0.25, [&](double t, const Vec& state) {
        if (t > 0) jumped -= state.norm();
      })));
  CHECK(y == 2 * last);
  CHECK(jumped == 0);
}

TEST_CASE("views of the user's own memory, controlled") {
  double memory[4] = {1, 2, 0, 1};
  Motion<Eigen::Map<Vec>> mapped{Eigen::Map<Vec>(memory), Eigen::Map<Vec>(memory + 2)};
  Moving owned{Vec(1, 2), Vec(0, 1)};
  const Push spring = [](const Vec& r, const Vec&, double) -> Vec { return -9 * r - r.squaredNorm() * r; };
  PhiStepper a{mapped, spring, velocity_verlet, mass(1.0)};
  PhiStepper b{owned, spring, velocity_verlet, mass(1.0)};
  const RunReport one = integrate(a, mapped, {0, 1}, tolerance{.rtol = 1e-4});
  const RunReport two = integrate(b, owned, {0, 1}, tolerance{.rtol = 1e-4});
  REQUIRE(one);
  CHECK(one.statistics == two.statistics);
  CHECK((mapped.r == owned.r && mapped.v == owned.v));
}

TEMPLATE_TEST_CASE("every scalar, controlled", "", float) {
  using F = problems::ForcedFlow<float>;
  auto y = F::exact(0);
  PhiStepper stepper{y, F{}, tr_bdf2, capacity(1.5f)};
  const RunReport report = integrate(stepper, y, {0.f, 2.f}, tolerance{.rtol = 1e-3});
  REQUIRE(report);
  CHECK(distance(y, F::exact(2)) <= 10 * 1e-3);
}

TEST_CASE("steps and rejections of the report are those of the run, whoever estimates") {
  for (const Scheme& each : schemes()) {
    CAPTURE(each.name);
    Vec y = Flow::exact(0);
    const auto run = each.ride(y, flow, Flow::capacity, {0.0, 2.0}, {.rtol = 1e-3, .first_step = 1}, {});
    std::int64_t steps = 0;
    while (run->advance()) ++steps;
    const RunReport report = run->report();
    CHECK(report.statistics.steps == steps);
    CHECK(report.statistics.rejections >= 1);
    CHECK(report.limits.steps() == steps);
  }
}

#elif PHISTEP_FULL
// run, every scheme: times, stops, counts.

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

#endif
