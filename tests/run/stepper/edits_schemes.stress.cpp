// Edited motions, every scheme; in short: edits.test.cpp.
#include "run/stepper/edits_cases.hpp"

using namespace edits_cases;

// Pull knows no velocity: Verlet carries it from step to step.
TEST_CASE("every scheme, dynamic motion: edited states are stepped as by a fresh stepper") {
  check_all<SecondOrder<Dynamic>>(Pull{});
}
TEST_CASE("every scheme, fixed motion") { check_all<SecondOrder<Fixed>>(Pull{}); }

// What is kept elsewhere for a state as it was: linear stages after a rejected try, the rounding of compensated sums.
TEST_CASE("an edit from +0 to -0 is seen by rejected tries and by compensated sums") {
  using Three = Eigen::Vector3d;
  Three y = Three::Zero();
  PhiStepper stepper{y, SignOfZero<Three>{}, rodas4};
  Trace<Three> trace;
  trace.resize(y);
  const auto attempt = [&](bool accept) {
    return stepper.attempt(y, 0.0, 0.125, Origin::unknown, trace, [accept](const auto&...) { return accept; });
  };
  REQUIRE(attempt(false).outcome() == Outcome::error_too_large);
  y = -y;
  trace.forget();
  Three z = y;
  PhiStepper fresh{z, SignOfZero<Three>{}, rodas4};
  REQUIRE(attempt(true));
  REQUIRE(fresh.step(z, 0.0, 0.125));
  CHECK(same_bits(numbers(y), numbers(z)));

  Motion<Three> a{Three{0.3, 0.7, 0}, Three{1, -0.3, 0}};
  const auto pull = [](const Three& r) -> Three { return -r; };
  PhiStepper used{a, pull, compensated(rkn86)};
  for (int n = 0; n < 10; ++n) REQUIRE(used.step(a, 0.1 * n, 0.1));
  a.r[2] = -0.0;
  auto b = a;
  PhiStepper other{b, pull, compensated(rkn86)};
  REQUIRE(used.step(a, 1.0, 0.1));
  REQUIRE(other.step(b, 1.0, 0.1));
  CHECK(same_bits(numbers(a), numbers(b)));
}
