// integrate, every scheme. The quick half is integrate.test.cpp.
#include "run/integrate_cases.hpp"

using namespace integrate_cases;

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
