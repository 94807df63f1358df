// Small programs of users: the recipes for a known jump, what samples say, and what they cost.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "support/catch.hpp"

using One = Eigen::Vector<double, 1>;

namespace {

enum class Recipe { nothing, at_times, row_of_runs, flag_and_reset };

/// y' = t − ⌊t⌋, y(10) = 5: the error in rtol, infinity where a run fails.
double off(Recipe recipe, double rtol, auto scheme) {
  One y{0};
  double base = 0;
  const bool by_flag = recipe == Recipe::flag_and_reset;
  const auto saw = [&](const One&, double t) -> One { return One{t - (by_flag ? base : std::floor(t))}; };
  std::vector<double> jumps;
  for (int k = 1; k < 10 && (by_flag || recipe == Recipe::at_times); ++k) jumps.push_back(k);
  const int runs = recipe == Recipe::row_of_runs ? 10 : 1;
  for (int k = 0; k < runs; ++k) {
    phistep::PhiStepper stepper{y, saw, scheme};
    const auto report =
        phistep::integrate(stepper, y, {10.0 * k / runs, 10.0 * (k + 1) / runs}, phistep::tolerance{.rtol = rtol},
                           phistep::at_times(jumps, [&](double t, One&) {
                             if (by_flag) base = std::round(t), stepper.reset();
                           }));
    if (!report) return std::numeric_limits<double>::infinity();
  }
  return std::abs(y[0] / 5 - 1) / rtol;
}
double worst(Recipe recipe) {
  double most = 0;
  for (const double rtol : {1e-4, 1e-6})
    most = std::max({most, off(recipe, rtol, phistep::tsit5), off(recipe, rtol, phistep::dop853),
                     off(recipe, rtol, phistep::radau), off(recipe, rtol, phistep::rodas5p),
                     off(recipe, rtol, phistep::tr_bdf2)});
  return most;
}

}  // namespace

TEST_CASE("a sawtooth: nothing said of the jumps") { CHECK(worst(Recipe::nothing) <= 100); }
TEST_CASE("a sawtooth: at_times and a flag with reset()") { CHECK(worst(Recipe::flag_and_reset) <= 1); }
TEST_CASE("a sawtooth: steps end on the jumps") { CHECK(worst(Recipe::at_times) <= 1); }
TEST_CASE("a sawtooth: a run ends on each jump") { CHECK(worst(Recipe::row_of_runs) <= 1); }

// The rate is a pulse 0.01 wide at t = 5; behind it the solution is a constant.
TEST_CASE("behind a pulse, the samples and the end of a run are one number") {
  const auto pulse = [](const One&, double t) -> One {
    return One{std::exp(-std::pow((t - 5) / 0.01, 2)) / (0.01 * std::sqrt(3.14159265358979323846))};
  };
  double apart = 0;
  for (const double rtol : {1e-5, 1e-9}) {
    One y{0};
    phistep::PhiStepper stepper{y, pulse, phistep::dop853};
    std::vector<double> seen;
    const auto report = phistep::integrate(stepper, y, {0, 10}, phistep::tolerance{.rtol = rtol},
                                           phistep::sampled(0.5, [&](double t, const One& now) {
                                             if (t > 5.2) seen.push_back(now[0]);
                                           }));
    if (report)  // a run that says it failed contradicts nobody
      for (const double value : seen) apart = std::max(apart, std::abs(value - y[0]));
  }
  CHECK(apart <= 1e-3);
}

namespace {

/// An orbit to t = 100: force calls with 400 samples over those without.
double cost_of_samples(auto scheme, double rtol) {
  using Vec = Eigen::Vector4d;
  const auto orbit = [](const Vec& y) -> Vec {
    const double pull = std::pow(y[0] * y[0] + y[1] * y[1], -1.5);
    return {y[2], y[3], -y[0] * pull, -y[1] * pull};
  };
  const auto calls = [&](double interval) {
    Vec y{1, 0, 0, 1};
    phistep::PhiStepper stepper{y, orbit, scheme};
    const auto report = phistep::integrate(stepper, y, {0, 100}, phistep::tolerance{.rtol = rtol},
                                           phistep::sampled(interval, [](double, const Vec&) {}));
    return report ? static_cast<double>(report.statistics.force_calls) : std::numeric_limits<double>::quiet_NaN();
  };
  return calls(0.25) / calls(1000);
}

}  // namespace

TEST_CASE("400 samples cost at most half of a run more: tsit5") {
  CHECK(cost_of_samples(phistep::tsit5, 1e-4) <= 1.5);
  CHECK(cost_of_samples(phistep::tsit5, 1e-6) <= 1.5);
  CHECK(cost_of_samples(phistep::tsit5, 1e-9) <= 1.5);
}
TEST_CASE("400 samples cost at most half of a run more: dop853") {
  CHECK(std::max({cost_of_samples(phistep::dop853, 1e-4), cost_of_samples(phistep::dop853, 1e-6),
                  cost_of_samples(phistep::dop853, 1e-9)}) <= 1.5);
}
// Today 1.8, 2.5 and 3.0.
TEST_CASE("400 samples cost at most half of a run more: radau", "[!shouldfail][48]") {
  CHECK(std::max({cost_of_samples(phistep::radau, 1e-4), cost_of_samples(phistep::radau, 1e-6),
                  cost_of_samples(phistep::radau, 1e-9)}) <= 1.5);
}
