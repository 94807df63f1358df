// run, every scalar. In short: run.test.cpp.
#include "run/run_cases.hpp"

using namespace run_cases;

TEMPLATE_TEST_CASE("every scalar, controlled", "", float, double, long double) {
  using T = TestType;
  using F = problems::ForcedFlow<T>;
  using M = problems::ForcedMotion<T>;
  const double rtol = sizeof(T) == 4 ? 1e-3 : 1e-6;
  const auto flow = [&](auto scheme) {
    auto y = F::exact(0);
    PhiStepper stepper{y, F{}, scheme, capacity(T(F::capacity))};
    const RunReport report = integrate(stepper, y, {T(0), T(2)}, tolerance{.rtol = rtol});
    REQUIRE(report);
    CHECK(distance(y, F::exact(2)) <= 10 * rtol);
  };
  flow(trapezoidal), flow(tr_bdf2), flow(midpoint);
  const auto motion = [&](auto scheme) {
    auto y = M::exact(0);
    PhiStepper stepper{y, M{}, scheme, mass(T(M::mass))};
    REQUIRE(integrate(stepper, y, {T(0), T(2)}, tolerance{.rtol = rtol}));
    CHECK(distance(y, M::exact(2)) <= 10 * rtol);
  };
  motion(trapezoidal), motion(velocity_verlet);
}
