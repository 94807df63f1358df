// Runge-Kutta-Nystrom pairs: every mass, shape and scalar, tolerances; the quick half is nystrom.test.cpp.
#include "contract/restart.hpp"
#include "problems/ten.hpp"

#include "schemes/nystrom/nystrom_cases.hpp"

using namespace nystrom_cases;

TEST_CASE("float reaches its rounding") {
  // 20 steps, each with a handful of roundings of numbers near 1, on a problem that magnifies them by less than 10.
  CHECK(error_at_end<float>(rkn86, 20) <= 20 * 10 * 1.2e-7);
  CHECK(error_at_end<float>(rkn1210, 10) <= 20 * 10 * 1.2e-7);
}

TEST_CASE("backward again: the start, to the error of the steps") {
  auto y = six();
  PhiStepper stepper{y, Hardening{}, rkn1210};
  REQUIRE(integrate(stepper, y, {0, 5}, fixed(0.1)));
  REQUIRE(integrate(stepper, y, {5, 0}, fixed(-0.1)));
  CHECK(distance(y, six()) <= 1e-12);
}

TEST_CASE("force calls: eight a step, the last of them for the next one; seventeen") {
  const auto calls = [](auto scheme, int steps) {
    auto y = six();
    PhiStepper stepper{y, Hardening{}, scheme};
    for (int n = 0; n < steps; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
    return stepper.statistics().force_calls;
  };
  CHECK(calls(rkn86, 10) == 8 * 10 + 1);
  CHECK(calls(rkn1210, 10) == 17 * 10);
  CHECK(calls(compensated(rkn1210), 10) == 17 * 10);
  auto y = six();
  PhiStepper stepper{y, Hardening{}, rkn1210};
  const RunReport run = integrate(stepper, y, {0, 20}, tolerance{.rtol = 1e-10});
  REQUIRE(run);
  // Each try sixteen, each step one more at its end; one at the start, and two for the first length.
  CHECK(run.statistics.force_calls == 16 * (run.statistics.steps + run.statistics.rejections) +
                                          (run.statistics.steps + run.statistics.rejections) + 3);
  CHECK(run.statistics.rejections <= run.statistics.steps / 4);
}

TEST_CASE("masses: none, one, one a component, a matrix") {
  const auto go = [](auto... m) { return march(PhiStepper{six(), Hardening{}, rkn86, m...}, six(), 0.0, 2.0, 20); };
  const auto one = go(), two = go(mass(2.0));
  // The same numbers by other roundings.
  CHECK(distance(two, go(mass(Vec(Vec::Constant(6, 2.0))))) <= 1e-13);
  CHECK(distance(two, go(mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(6, 6))))) <= 1e-13);
  CHECK(distance(one, two) > 0.1);
}

TEST_CASE("every shape of a state gives the same") {
  const auto go = []<class V>(std::type_identity<V>) {
    states::SecondOrder<V> scene;
    PhiStepper stepper{scene.state, states::Pull{}, rkn86};
    for (int n = 0; n < 10; ++n) problems::step(stepper, scene.state, 0.0, 0.2);
    return states::numbers(scene.state);
  };
  const Vec fixed = go(std::type_identity<states::Fixed>{});
  CHECK((go(std::type_identity<states::RowMajor>{}) - fixed).norm() <= 1e-13);
  CHECK((go(std::type_identity<states::Strided>{}) - fixed).norm() <= 1e-13);
}

TEST_CASE("the error at the end follows the tolerance, on two orbits of a comet") {
  const problems::Kepler kepler;
  const problems::Case problem{
      "Kepler", kepler, kepler.start(), kepler.exact(2 * problems::Kepler::period), 2 * problems::Kepler::period,
      1.0,      false};
  const double kappa = problems::conditioning(problem);
  const auto check = [&](auto scheme) {
    double first = 0, last = 0;
    for (int digits = 3; digits <= 11; ++digits) {
      const double rtol = std::pow(10.0, -digits);
      auto y = problem.start;
      PhiStepper stepper{y, kepler, scheme};
      const RunReport run = integrate(stepper, y, {0, problem.end}, tolerance{.rtol = rtol, .atol = rtol});
      CAPTURE(digits, run.message());
      REQUIRE(run);
      last = problems::relative_error(y, problem);
      if (digits == 3) first = last;
      CHECK(last <= 10 * kappa * rtol);
    }
    const double slope = std::log10(first / last) / 8;
    CAPTURE(first, last, slope);
    CHECK(slope >= 0.8);
    CHECK(slope <= 1.1);
  };
  check(rkn86);
  check(rkn1210);
}

TEST_CASE("looked at inside of steps, a run is as good as at their ends") {
  const problems::Kepler kepler{0.3};
  auto y = kepler.start();
  PhiStepper stepper{y, kepler, rkn1210};
  double worst = 0;
  int looks = 0;
  const RunReport run =
      integrate(stepper, y, {0, 6}, tolerance{.rtol = 1e-9, .atol = 1e-9}, sampled(0.1, [&](double t, const auto& at) {
                  worst = std::max(worst, distance(at, kepler.exact(t)));
                  ++looks;
                }));
  REQUIRE(run);
  CHECK(looks >= 60);
  CHECK(run.statistics.steps <= 30);
  CHECK(worst <= 100 * 1e-9);  // κ of most of an orbit is below 100
}

TEST_CASE("a force that fails in the middle of a step leaves the state as it was") {
  const auto check = [](auto scheme, const Wall& wall, auto... m) {
    auto y = six();
    const auto before = restart::bytes(y);
    PhiStepper stepper{y, wall, scheme, m...};
    const StepReport report = stepper.step(y, 0.0, 0.2);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK(report.failure().index == 3);
    CHECK(restart::bytes(y) == before);
  };
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (const double from : {-1.0, 0.001, 0.05, 0.15, 0.1999}) {
      CAPTURE(value, from);
      const Wall wall{{}, from, value};
      check(rkn86, wall);
      check(rkn1210, wall);
      check(rkn1210, wall, mass(Eigen::MatrixXd(Eigen::MatrixXd::Identity(6, 6))));  // M⁻¹ would spread it
    }
}

TEST_CASE("units that are powers of two change no bit") {
  const auto go = [](double length, double time) {
    auto y = six();
    y.r *= length;
    y.v *= length / time;
    const double k = 1 / (time * time);
    PhiStepper stepper{y, Hardening{{}, 2 * k, k / (length * length)}, rkn1210};
    REQUIRE(
        integrate(stepper, y, {0, 8 * time}, tolerance{.rtol = 1e-9, .atol = {1e-9 * length, 1e-9 * length / time}}));
    y.r /= length;
    y.v *= time / length;
    return restart::bytes(y);
  };
  CHECK(go(1, 1) == go(0x1p-40, 0x1p20));
}
