// Halving in dynamic vectors, in runs and in another halving; the quick half is halving.test.cpp.
#include "run/stepper/halving_cases.hpp"

using namespace halving_cases;

TEST_CASE("a final failure after good parts leaves state and history to the bit, as does an exception") {
  check_final_failure(Motion<Vec>{Vec::Ones(2), Vec::Constant(2, 0.3)});
}

TEST_CASE("where nothing fails, halving changes no bit and no count") {
  states::SecondOrder<Vec> a, b;
  Halving halving{PhiStepper{a.state, states::Pull{}, velocity_verlet}};
  PhiStepper bare{b.state, states::Pull{}, velocity_verlet};
  const RunReport one = integrate(halving, a.state, {0, 1}, fixed(0.1)),
                  other = integrate(bare, b.state, {0, 1}, fixed(0.1));
  CHECK(one);
  CHECK(states::same_bits(states::numbers(a.state), states::numbers(b.state)));
  CHECK(one.statistics == other.statistics);
}

TEST_CASE("halving halves another halving, and maps in place") {
  states::FirstOrder<states::Strided> c;
  const auto cubic = [](const Vec& y) -> Vec { return 3 * y; };
  Halving stepper{Halving{PhiStepper{c.state, cubic, backward_euler}, 0}, 1};
  REQUIRE(stepper.step(c.state, 0.0, 1.0 / 3));
  CHECK(c.state[0] == Approx(4 * states::positions[0]).epsilon(1e-14));
  CHECK(stepper.statistics().halvings == 1);
}
