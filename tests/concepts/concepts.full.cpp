// Every spelling of a stepper that the documentation shows. The quick half is concepts.test.cpp.
#include <phistep/phistep.hpp>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

using R = decltype([](const Dynamic& r) -> Dynamic { return r; });

TEST_CASE("every order of optional arguments that the documentation shows deduces") {
  Dynamic y = Dynamic::Ones(2);
  const R force{};
  CHECK(PhiStepper{y, force, trapezoidal}.step(y, 0, 0.1));
  CHECK(PhiStepper{y, force, trapezoidal, mass(2.0)}.step(y, 0, 0.1));
  CHECK(PhiStepper{y, force, trapezoidal, capacity(2.0)}.step(y, 0, 0.1));
  CHECK(PhiStepper{y, force, trapezoidal, newton({.rtol = 1e-6})}.step(y, 0, 0.1));
  CHECK(PhiStepper{y, force, trapezoidal, mass(2.0), newton()}.step(y, 0, 0.1));
}
