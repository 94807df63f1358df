// A scheme composed to order 8: with friction, under a tolerance, restarted; the quick half is composed.test.cpp.
#include "contract/restart.hpp"

#include "schemes/composed_cases.hpp"

using namespace composed_cases;

TEST_CASE("order 8 where the force depends on v: in a magnetic field, and driven with friction") {
  using L = long double;
  const auto run = [](int n) {
    return march(PhiStepper{two<L>(), Magnetic<L>{}, composed(velocity_verlet)}, two<L>(), L(0), L(2), n);
  };
  const auto end = run(8 * 24);
  const double coarse = distance(run(12), end), fine = distance(run(24), end);
  CAPTURE(coarse, fine);
  CHECK(std::abs(std::log2(coarse / fine) - 8) <= 0.4);
  using Forced = problems::ForcedMotion<L>;
  const auto error = [](int n) {
    PhiStepper stepper{Forced::exact(0), Forced{}, composed(velocity_verlet), mass(static_cast<L>(Forced::mass))};
    return distance(march(stepper, Forced::exact(0), L(0), L(2), n), Forced::exact(2));
  };
  CHECK(std::abs(std::log2(error(20) / error(40)) - 8) <= 0.4);
}

TEST_CASE("under a tolerance, by step doubling") {
  auto y = problems::Kepler{}.start();
  PhiStepper stepper{y, problems::Kepler{}, composed(velocity_verlet)};
  const RunReport run = integrate(stepper, y, {0, 2 * problems::Kepler::period}, tolerance{.rtol = 1e-9});
  REQUIRE(run);
  // κ of two such orbits is about 400.
  CHECK(distance(y, problems::Kepler{}.exact(0)) <= 10 * 400 * 1e-9);
}

TEST_CASE("symmetric: a step there and back is none, to rounding") {
  auto y = two<double>();
  PhiStepper stepper{y, Magnetic<double>{}, composed(velocity_verlet)};
  problems::step(stepper, y, 0.0, 0.2);
  CHECK(distance(y, two<double>()) > 0.01);
  problems::step(stepper, y, 0.2, -0.2);
  // 34 substeps, the longest of 0.56 Δt, each with a few roundings of numbers near 1, magnified by less than 2.
  CHECK(distance(y, two<double>()) <= 34 * 3 * 2 * 1.2e-16);
}

TEST_CASE("a force that isn't finite leaves the state as it was") {
  auto y = six();
  const auto before = restart::bytes(y);
  PhiStepper stepper{y,
                     [](const Vec& r, const Vec& v, double t) -> Vec {
                       if (t > 0.1) return r / 0.0;
                       return -r - 0.1 * v;
                     },
                     composed(velocity_verlet)};
  CHECK(stepper.step(y, 0.0, 0.2).outcome() == Outcome::non_finite_force);
  CHECK(restart::bytes(y) == before);
}

TEST_CASE("a restart gives the same bits") {
  restart::check({0.05, false}, six, [](const auto& y) {
    return PhiStepper{y, states::DampedPull{}, composed(velocity_verlet)};
  });
}
