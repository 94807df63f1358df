// The outer solar system over a million years: energy, angular momentum, momentum; drift or walk; what compensated sums cost.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <string>
#include <vector>

#include "../../bench/solar_system/problem.hpp"
#include "endurance/drift.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

namespace {

constexpr double u = 0x1p-53, years = 1e6, year = 365.25;  // [d]
using Long3 = Eigen::Matrix<long double, 3, 1>;

/// Σ m r × v, and Σ m v.
struct Momenta {
  Long3 angular = Long3::Zero(), linear = Long3::Zero();
  explicit Momenta(const Planets::State& y) {
    for (int i = 0; i < 6; ++i) {
      const long double m = Planets::masses[static_cast<std::size_t>(i)];
      const Eigen::Matrix<long double, 3, 1> r{y.r[i], y.r[6 + i], y.r[12 + i]}, v{y.v[i], y.v[6 + i], y.v[12 + i]};
      angular += m * Long3{r[1] * v[2] - r[2] * v[1], r[2] * v[0] - r[0] * v[2], r[0] * v[1] - r[1] * v[0]};
      linear += m * v;
    }
  }
};

struct Result {
  endurance::Trend energy, angular;
  double momentum = 0, seconds = 0;
};
Result run(const std::string& name, auto scheme, double dt) {
  const Planets force;
  auto y = Planets::start();
  phistep::PhiStepper stepper{y, force, scheme};
  const long double E = Planets::energy(y);
  const Momenta before{y};
  // Of each body's, the sizes: what rounding is relative to.
  long double size = 0;
  for (int i = 0; i < 6; ++i)
    size += Planets::masses[static_cast<std::size_t>(i)] * std::hypot(y.v[i], y.v[6 + i], y.v[12 + i]);
  timespec from{}, to{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &from);
  auto series = endurance::follow(
      {name + ", energy", name + ", angular momentum", name + ", momentum"},
      static_cast<std::int64_t>(years * year / dt) / 256 * 256,
      [&](std::int64_t n, std::int64_t m) {
        const double t0 = static_cast<double>(n) * dt, t1 = static_cast<double>(m) * dt;
        const auto report = phistep::integrate(stepper, y, {t0, t1}, phistep::fixed(dt));
        if (!report) FAIL(report.message());
      },
      [&] {
        const Momenta now{y};
        return std::array<long double, 3>{(Planets::energy(y) - E) / E,
                                          (now.angular.norm() - before.angular.norm()) / before.angular.norm(),
                                          (now.linear - before.linear).norm() / size};
      });
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &to);
  const double seconds =
      static_cast<double>(to.tv_sec - from.tv_sec) + 1e-9 * static_cast<double>(to.tv_nsec - from.tv_nsec);
  return {series[0].trend(), series[1].trend(), series[2].worst(), seconds};
}

/// max |dE/E| of all steps of 4000 years.
double swing(auto scheme, double dt) {
  const Planets force;
  auto y = Planets::start();
  phistep::PhiStepper stepper{y, force, scheme};
  const long double E = Planets::energy(y);
  long double worst = 0;
  for (int n = 0; n < 4000 * year / dt; ++n) {
    problems::step(stepper, y, n * dt, dt);
    worst = std::max(worst, std::abs(Planets::energy(y) / E - 1));
  }
  return static_cast<double>(worst);
}

double seconds_of(auto scheme, int steps) {
  const Planets force;
  auto y = Planets::start();
  phistep::PhiStepper stepper{y, force, scheme};
  timespec from{}, to{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &from);
  const auto report = phistep::integrate(stepper, y, {0.0, steps * 200.0}, phistep::fixed(200));
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &to);
  REQUIRE(report);
  return static_cast<double>(to.tv_sec - from.tv_sec) + 1e-9 * static_cast<double>(to.tv_nsec - from.tv_nsec);
}

void tell(const std::string& name, const Result& result) {
  figures::told(result.energy.worst, name, "1e6 years: max |dE/E|");
  figures::told(result.energy.slope / u, name, "drift of E [u/step]");
  figures::told(result.energy.exponent, name, "exponent of the energy error");
  figures::told(result.angular.worst, name, "1e6 years: max |dL/L|");
  figures::told(result.momentum, name, "1e6 years: |sum m v| / sum m|v|");
  figures::told(result.seconds, name, "CPU seconds");
}

}  // namespace

TEST_CASE("a million years, symplectic: the energy error neither drifts nor grows") {
  const auto check = [](const std::string& name, auto scheme, double dt) {
    const double soon = swing(scheme, dt);
    const Result result = run(name, scheme, dt);
    tell(name, result);
    // The planets meet in ever other ways, those of four thousand years are most of them.
    figures::at_most(1.5 * soon, result.energy.worst, name + ": the energy error stays what it was in 4000 years",
                     "1e6 years: max |dE/E|");
    figures::at_most(5, std::abs(result.energy.t), name + ": the energy does not drift", "|t| of Student's test");
    figures::at_most(5, std::abs(result.angular.t), name + ": L does not drift", "|t| of Student's test");
  };
  check("Verlet, 40 d", phistep::velocity_verlet, 40);
  check("SRKN11b, 75 d", phistep::srkn11b, 75);
}

TEST_CASE("a million years by RKN12(10): what is left to rounding, and compensated sums") {
  const Result plain = run("RKN12(10), 200 d", phistep::rkn1210, 200),
               exact = run("RKN12(10), 200 d, compensated", phistep::compensated(phistep::rkn1210), 200);
  tell("RKN12(10), 200 d", plain);
  tell("RKN12(10), 200 d, compensated", exact);
  // Its coefficients, rounded to double, are another method's by a share of u, always the same: a drift. Compensated, they
  // have all their digits.
  figures::at_most(0.1, std::abs(plain.energy.slope) / u, "RKN12(10): E drifts by less than a tenth of a rounding",
                   "|drift| [u/step]");
  figures::at_most(1e-13, exact.energy.worst, "RKN12(10), compensated: the energy", "1e6 years: max |dE/E|");
  figures::at_most(1e-13, exact.angular.worst, "RKN12(10), compensated: L", "1e6 years: max |dL/L|");
  std::vector<double> ratios;
  for (int k = 0; k < 9; ++k) {
    const double one = seconds_of(phistep::rkn1210, 10000);
    ratios.push_back(seconds_of(phistep::compensated(phistep::rkn1210), 10000) / one);
  }
  std::sort(ratios.begin(), ratios.end());
  figures::told(ratios[4], "compensated sums cost", "CPU time ratio on six bodies, median of 9");
}
