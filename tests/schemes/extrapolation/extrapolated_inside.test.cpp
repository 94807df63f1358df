// What an extrapolated step tells of the solution between its ends serves the search for events alone: nobody else may look
// (compile/sampled_extrapolated, compile/step_at_extrapolated).
#include <phistep/phistep.hpp>
#include <phistep/schemes/extrapolation/extrapolated.hpp>

#include <cmath>

#include "problems/kepler.hpp"
#include "support/catch.hpp"

#pragma GCC diagnostic ignored "-Wdeprecated-declarations"  // of two kinds, which leave in 0.3

using namespace phistep;

TEST_CASE("an event cuts a step where it happens, to the accuracy of the run") {
  const problems::Kepler kepler;
  for (const double rtol : {1e-5, 1e-9}) {
    auto y = kepler.start();
    PhiStepper stepper{y, kepler, extrapolated(backward_euler)};
    double when = 0;
    // r_x = −e − … : the apocentre side is crossed at a quarter of the eccentric anomaly E = π/2.
    const auto report = integrate(stepper, y, {0, 3}, tolerance{.rtol = rtol, .atol = rtol},
                                  event([](double, const auto& x) { return x.r[0] + 0.6; }, {},
                                        [&](double t, auto&) { return when = t, false; }));
    CHECK(report.outcome == Outcome::stopped_by_event);
    // Kepler's equation: t = π/2 − e.
    CHECK(std::abs(when - (1.5707963267948966 - 0.6)) <= 100 * rtol);
  }
}
