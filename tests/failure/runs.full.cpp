// runs: the full product and what is dear to compile. The quick half is runs.test.cpp.
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
  CHECK(integrate(stepper, y, {2, 2}, tolerance{}, [](double, const Vec&) { return false; }).outcome ==
        Outcome::stopped_by_observer);
}

TEST_CASE("options that can't work are refused before anything happens") {
  const auto refused = [](const auto& control, TimeSpan<double> span = {0, 1}) {
    Vec y(1, 2);
    PhiStepper stepper{y, decay, trapezoidal};
    int shown = 0;
    const RunReport report = integrate(stepper, y, span, control, Look([&](double, const Vec&) { ++shown; }));
    CHECK(shown == 0);
    CHECK(y == Vec(1, 2));
    CHECK(report.t == Approx(span.t0));
    CHECK(report.statistics == Statistics{});
    CHECK_FALSE(report.message().empty());
    return report.outcome;
  };
  using enum Outcome;
  for (const double rtol : {0.0, -1e-4, NaN, inf, 1.0, 1e-15, 1e-300})
    CHECK(refused(tolerance{.rtol = rtol}) == invalid_tolerance);
  for (const double atol : {-1.0, NaN, inf}) CHECK(refused(tolerance{.atol = atol}) == invalid_tolerance);
  CHECK(refused(tolerance{.atol = {1.0, 1.0}}) == invalid_tolerance);
  CHECK(refused(tolerance{.atol = Eigen::VectorXd::Ones(3).eval()}) == invalid_tolerance);
  for (const double bad : {-1.0, NaN}) {
    CHECK(refused(tolerance{.first_step = bad}) == invalid_tolerance);
    CHECK(refused(tolerance{.min_step = bad}) == invalid_tolerance);
    CHECK(refused(tolerance{.max_step = bad}) == invalid_tolerance);
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
  CHECK(refused(tolerance{.max_step = 0.0}) == invalid_tolerance);
  CHECK(refused(tolerance{.min_step = 0.1, .max_step = 0.05}) == invalid_tolerance);
  CHECK(refused(tolerance{.max_steps = -1}) == invalid_tolerance);
  CHECK(refused(iteration_control{}) == invalid_tolerance);
  CHECK(refused(iteration_control{.first_step = 0.1, .desired = 0}) == invalid_tolerance);
  CHECK(refused(smaller_of(tolerance{}, iteration_control{.desired = 0})) == invalid_tolerance);
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
  CHECK(integrate(stepper, y, {0, 1}, iteration_control{.first_step = 0.1}).outcome == Outcome::non_finite_state);
  Vec z(1, 2);
  PhiStepper nowhere{z, Psi([](const Vec&, double) -> Vec { return Vec(NaN, 0); }), trapezoidal};
  const RunReport report = integrate(nowhere, z, {0, 1}, tolerance{});
  CHECK(report.outcome == Outcome::non_finite_force);
  CHECK_THAT(report.message(), contains("force is not finite"));
  CHECK(z == Vec(1, 2));
}

TEST_CASE("through a pole there is no way: the run says so, the last good state stays") {
  for_each_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    Vec y(1, 0.5);
    PhiStepper stepper{y, square, scheme};
    double shown = 0;
    Vec last = y;
    // An order-1 scheme takes 1/(√2 rtol) steps while y grows e-fold, and y grows by e^37 until Δt is rounding: 26,000
    // steps at rtol = 1e-3.
    const RunReport report = integrate(stepper, y, {0, 3}, tolerance{.rtol = 1e-3, .max_steps = 200'000},
                                       Look([&](double t, const Vec& now) { shown = t, last = now; }));
    check_at_pole(report, y, shown, last);
  });
}

TEST_CASE("a force that is no number from a time on: named, and the run ends before it") {
  for_each_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    const Psi force = [](const Vec& y, double t) -> Vec { return t > 0.5 ? Vec(NaN, 1) : Vec(-y); };
    Vec y(1, 2);
    PhiStepper stepper{y, force, scheme};
    const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-4, .max_steps = 10'000});
    check_before_nan(report, y);
  });
}

TEST_CASE("a force that throws, at whatever call: the last good step stands, and the run can go on") {
  const auto check = [](auto start, auto psi, auto scheme, auto&& exact, const auto& control) {
    int calls = 0, fatal = 0;
    const auto force = [&calls, &fatal, psi](const auto&... args) {
      if (++calls == fatal) throw std::runtime_error("no more");
      return psi(args...);
    };
    using S = decltype(start);
    int total = 0;
    for (int k = 0; k == 0 || k <= total; k += 1 + k / 40) {
      S y = start, last = start;
      calls = 0, fatal = k;
      PhiStepper stepper{
          y,
          typename std::conditional_t<Blocks<S>::drifts,
                                      std::type_identity<std::function<Vec(const Vec&, const Vec&, double)>>,
                                      std::type_identity<std::function<Vec(const Vec&, double)>>>::type(force),
          scheme};
      Run run{stepper, y, {0.0, 1.0}, control};
      int thrown = 0;
      double t = 0;
      for (bool more = true; more;) {
        try {
          more = run.advance();
        } catch (const std::runtime_error&) {
          ++thrown;
          CHECK(run.time() == t);
          CHECK(states::same_bits(states::numbers(y), states::numbers(last)));
          CHECK_FALSE(run.has_ended());
        }
        last = y, t = run.time();
      }
      CAPTURE(k, run.report().message());
      CHECK(run.report());
      CHECK(run.time() == 1);
      CHECK(distance(y, exact(1.0)) <= 1e-2);
      if (k == 0) total = calls;
      else CHECK(thrown == 1);
    }
  };
  const auto flow = [](const Vec& y, double t) -> Vec { return Flow{}(y, t) / Flow::capacity; };
  const auto swing = [](const Vec& r, const Vec& v, double t) -> Vec { return Swing{}(r, v, t) / Swing::mass; };
  const auto all = [&](const auto& control) {
    check(Flow::exact(0), flow, trapezoidal, Flow::exact, control);
    check(Flow::exact(0), flow, tr_bdf2, Flow::exact, control);
    check(Flow::exact(0), flow, midpoint, Flow::exact, control);
    check(Swing::exact(0), swing, velocity_verlet, Swing::exact, control);
    check(Swing::exact(0), swing, backward_euler, Swing::exact, control);
  };
  all(tolerance{.rtol = 1e-3});
  check(Flow::exact(0), flow, trapezoidal, Flow::exact, fixed(0.02));
  check(Flow::exact(0), flow, trapezoidal, Flow::exact, iteration_control{.first_step = 0.01, .max_step = 0.02});
}

TEST_CASE("a jump in the force is passed, in short steps") {
  const Psi force = [](const Vec&, double t) -> Vec { return t < 1.0 / 3 ? Vec(1, -1) : Vec(-2, 5); };
  for_each_scheme([&](const char* name, auto scheme) {
    CAPTURE(name);
    Vec y(0.5, 0.5);
    PhiStepper stepper{y, force, scheme};
    const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-4, .max_steps = 5000});
    REQUIRE(report);
    CHECK(distance(y, Vec(0.5 + 1.0 / 3 - 4.0 / 3, 0.5 - 1.0 / 3 + 10.0 / 3)) <= 1e-3);
  });
}
