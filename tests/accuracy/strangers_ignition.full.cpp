// Ignitions, as a newcomer writes them: with rtol alone, and with an atol that a radical from 0 needs.
#include <phistep/automatic.hpp>

#include "accuracy/mechanisms.hpp"

#include <algorithm>
#include <cmath>

#include "problems/hydrogen.hpp"
#include "support/catch.hpp"

namespace {

using mechanisms::Vec;

/// The time at which the temperature passes 1050, without a stepper; 0 where the run fails.
double ignition_time(double rtol, const phistep::AbsoluteTolerance& atol) {
  mechanisms::Member m = mechanisms::ignition();
  m.rates.unit = Vec::Ones(5);
  double found = 0;
  auto hot = phistep::event([](const Vec& y) { return y[4] - 1050; }, {.direction = phistep::Direction::rising},
                            [&found](double t, Vec&) { found = t; });
  Vec y = m.start;
  const phistep::tolerance control{.rtol = rtol, .atol = atol, .max_steps = 100'000};
  return phistep::integrate(y, m.rates, {0, m.time}, control, hot) ? found : 0;
}
/// By radau and by dop853 at rtol 1e-13, .atol 1e-22; they agree in 14 digits.
constexpr double exact_time = 5.25883736679428e-4;

/// The error of the ignition time in units of rtol, the worst of rtol 1e-3 … 1e-9.
double worst_error(bool with_atol) {
  double worst = 0;
  for (const double rtol : {1e-3, 1e-5, 1e-7, 1e-9}) {
    const double t = with_atol ? ignition_time(rtol, 1e-6 * rtol) : ignition_time(rtol, {});
    worst = std::max(worst, std::abs(t / exact_time - 1) / rtol);
  }
  return worst;
}

/// The temperature [K] of burnt hydrogen by rodas5p; 0 where the run fails.
double burnt(double rtol, const phistep::AbsoluteTolerance& atol) {
  using State = problems::Hydrogen::State;
  State y = problems::Hydrogen::start();
  phistep::PhiStepper stepper{y, problems::Hydrogen{}, phistep::rodas5p};
  const phistep::tolerance control{.rtol = rtol, .atol = atol, .max_steps = 100'000};
  return phistep::integrate(stepper, y, {0, problems::Hydrogen::end}, control) ? y[0] : 0;
}

}  // namespace

TEST_CASE("ignition: with an atol for its radical its time is right to 100 rtol") { CHECK(worst_error(true) < 100); }
TEST_CASE("ignition: with rtol alone its time is right to 100 rtol") { CHECK(worst_error(false) < 100); }

TEST_CASE("hydrogen: with an atol for its radicals it ignites, and burns to the exact temperature") {
  for (const double rtol : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7}) {
    CAPTURE(rtol);
    CHECK(std::abs(burnt(rtol, 1e-6 * rtol) / problems::Hydrogen::burnt - 1) < rtol);
  }
}
TEST_CASE("hydrogen: with rtol alone it ignites, and burns to the exact temperature") {
  double worst = 0;
  for (const double rtol : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7})
    worst = std::max(worst, std::abs(burnt(rtol, {}) / problems::Hydrogen::burnt - 1) / rtol);
  CHECK(worst < 100);
}
