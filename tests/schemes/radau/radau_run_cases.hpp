#pragma once

// What the quick and the full half of schemes/radau/radau_run share.
#include <phistep/phistep.hpp>
#include <phistep/schemes/radau/radau.hpp>

#include <cmath>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "problems/hires.hpp"
#include "problems/kepler.hpp"
#include "problems/oregonator.hpp"
#include "problems/robertson.hpp"
#include "problems/van_der_pol.hpp"
#include "support/catch.hpp"

using namespace phistep;

namespace radau_run_cases {

/// Slope of log error over log rtol, by least squares.
struct Regression {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  void add(double a, double b) { n += 1, x += a, y += b, xx += a * a, xy += a * b; }
  [[nodiscard]] double slope() const { return (n * xy - x * y) / (n * xx - x * x); }
};

/// @param kappa  how the problem amplifies errors of size rtol on the way (tests/problems/ten.hpp has it by perturbation)
/// @param a      atol = a rtol
template <class Problem, class Error>
void check_law(const char* name, Problem problem, double a, double kappa, Radau scheme, Error error) {
  Regression regression;
  // Errors scatter by factors of ten from tolerance to tolerance: many of them, so that the slope is one.
  for (double digits = 2; digits <= 12; digits += 0.125) {
    const double rtol = std::pow(10.0, -digits);
    auto y = Problem::start();
    PhiStepper stepper{y, problem, scheme};
    const RunReport report = integrate(stepper, y, {0, Problem::end}, tolerance{.rtol = rtol, .atol = a * rtol});
    CAPTURE(name, scheme.stages, rtol, report.message());
    REQUIRE(report);
    const double off = error(y);
    CHECK(off <= 10 * kappa * rtol);
    // Below, rounding has a part: u times the condition of T (650 for 7 stages) times κ is 7e-12 for HIRES.
    if (digits <= 10) regression.add(std::log(rtol), std::log(std::max(off, 1e-16)));
  }
  CAPTURE(name, scheme.stages);
  CHECK(regression.slope() >= 0.8);
  // 1.1 but for tolerances below 5e-7, where the estimate is held to 16 times them: what isn't stiff then goes as rtol^{13/8}.
  CHECK(regression.slope() <= 1.15);
}

inline double worst(const auto& y, const auto& exact, double a) {
  return ((y - exact).array().abs() / (exact.array().abs() + a)).maxCoeff();
}

}  // namespace radau_run_cases
