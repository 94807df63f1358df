// A symmetric scheme composed to order 8: velocity Verlet with forces that depend on v or not, the midpoint rule.
#include "schemes/composed_cases.hpp"

using namespace composed_cases;

TEST_CASE("order 8 in long double, driven") {
  using Problem = problems::DrivenMotion<long double>;
  const auto error = [](int n) {
    PhiStepper stepper{Problem::exact(0), Problem{}, composed(velocity_verlet),
                       mass(static_cast<long double>(Problem::mass))};
    return distance(march(stepper, Problem::exact(0), 0.0L, 3.0L, n), Problem::exact(3));
  };
  check_order(errors(10, error), 8, 0.1);
}

TEST_CASE("order 8 where the force depends on v: in a magnetic field, and driven with friction") {
  using L = long double;
  const auto run = [](int n) {
    return march(PhiStepper{two<L>(), Magnetic<L>{}, composed(velocity_verlet)}, two<L>(), L(0), L(2), n);
  };
  const auto end = run(8 * 24);
  const double coarse = distance(run(12), end), fine = distance(run(24), end);
  CAPTURE(coarse, fine);
  CHECK(std::abs(std::log2(coarse / fine) - 8) <= 0.4);
}

TEST_CASE("order 8 for a first-order state, by the midpoint rule") {
  using Flow = problems::ForcedFlow<>;
  const auto error = [](int n) {
    PhiStepper stepper{Flow::exact(0), Flow{}, composed(midpoint), capacity(Flow::capacity)};
    return distance(march(stepper, Flow::exact(0), 0.0, 2.0, n), Flow::exact(2));
  };
  CHECK(std::abs(std::log2(error(8) / error(16)) - 8) <= 0.6);
}

TEST_CASE("seventeen force calls a step, and one more at the start of a run") {
  auto y = six();
  PhiStepper stepper{y, states::Pull{}, composed(velocity_verlet)};
  for (int n = 0; n < 10; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
  CHECK(stepper.statistics().force_calls == 17 * 10 + 1);
}

TEST_CASE("symmetric: a step there and back is none, to rounding") {
  using L = long double;
  auto y = two<L>();
  PhiStepper stepper{y, Magnetic<L>{}, composed(velocity_verlet)};
  problems::step(stepper, y, 0.0L, 0.2L);
  CHECK(distance(y, two<L>()) > 0.01);
  problems::step(stepper, y, 0.2L, -0.2L);
  // 34 substeps, the longest of 0.56 Δt, each with a few roundings of numbers near 1, magnified by less than 2.
  CHECK(distance(y, two<L>()) <= 34 * 3 * 2 * static_cast<double>(std::numeric_limits<L>::epsilon()) / 2);
}
