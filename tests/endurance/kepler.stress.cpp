// Kepler's ellipse of e = 0.6 for up to 10⁷ steps: energy, angular momentum, and where the planet is.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <string>
#include <vector>

#include "endurance/drift.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

namespace {

using problems::Kepler;
constexpr double u = 0x1p-53;

long double energy(const Kepler::State& y) {
  const long double x = y.r[0], z = y.r[1], v = y.v[0], w = y.v[1];
  return (v * v + w * w) / 2 - 1 / std::sqrt(x * x + z * z);
}
long double angular_momentum(const Kepler::State& y) {
  return static_cast<long double>(y.r[0]) * y.v[1] - static_cast<long double>(y.r[1]) * y.v[0];
}

struct Errors {
  endurance::Series energy, momentum, time;
  double swing = 0;  ///< max |dH/H| over all steps of the first twenty periods
};
/// Relative errors of E and L, and by how much the planet is late.
Errors follow(const std::string& name, auto scheme, int a_period, double steps) {
  const Kepler kepler;
  auto y = kepler.start();
  phistep::PhiStepper stepper{y, kepler, scheme};
  const double h = Kepler::period / a_period;
  const long double E = energy(y), L = angular_momentum(y);
  Errors errors;
  for (auto x = y; errors.time.e.size() <= static_cast<std::size_t>(20 * a_period); errors.time.e.push_back(0)) {
    problems::step(stepper, x, 0.0, h);
    errors.swing = std::max(errors.swing, static_cast<double>(std::abs(energy(x) / E - 1)));
  }
  std::int64_t n = 0;
  auto series = endurance::follow(
      {name + ", energy", name + ", angular momentum", name + ", time"}, static_cast<std::int64_t>(steps),
      [&](std::int64_t from, std::int64_t to) {
        const double t0 = static_cast<double>(from) * h, t1 = static_cast<double>(to) * h;
        const auto report = phistep::integrate(stepper, y, {t0, t1}, phistep::fixed(h));
        if (!report) FAIL(report.message());
        n = to;
      },
      [&] {
        const auto exact = kepler.exact(static_cast<double>(n % a_period) * h);
        const double late = exact.v.dot(exact.r - y.r) / exact.v.squaredNorm();
        return std::array<long double, 3>{energy(y) / E - 1, angular_momentum(y) / L - 1, late};
      });
  errors.energy = std::move(series[0]), errors.momentum = std::move(series[1]), errors.time = std::move(series[2]);
  return errors;
}

double seconds_of(auto scheme, int steps) {
  const Kepler kepler{0.1};
  auto y = kepler.start();
  phistep::PhiStepper stepper{y, kepler, scheme};
  timespec from{}, to{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &from);
  const auto report = phistep::integrate(stepper, y, {0.0, steps * 0.1}, phistep::fixed(0.1));
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &to);
  REQUIRE(report);
  return static_cast<double>(to.tv_sec - from.tv_sec) + 1e-9 * static_cast<double>(to.tv_nsec - from.tv_nsec);
}

}  // namespace

TEST_CASE("Kepler: symplectic schemes keep the angular momentum to rounding and the energy within a bound") {
  const auto check = [](const std::string& name, auto scheme, int a_period, double steps) {
    const auto errors = follow(name, scheme, a_period, steps);
    const auto E = errors.energy.trend(), L = errors.momentum.trend();
    const std::string which = figures::text(steps) + " steps: ";
    if constexpr (decltype(scheme)::facts.is_explicit) {
      // Kicks along r, drifts along v: each rounds r × v by 2u at most, of up to |r||v| = 1.25 L where that is largest. Five
      // deviations of a walk of the 4 steps by 11 in a step.
      figures::at_most(5 * 2 * 1.25 * u * std::sqrt(steps * 11), L.worst, name + " keeps the angular momentum",
                       which + "max |dL/L|");
      figures::at_most(5, std::abs(L.t), name + ": L does not drift", which + "|t| of Student's test");
    } else {
      figures::at_most(0.1, std::abs(L.slope) / u, name + ": L drifts by less than a tenth of a rounding",
                       which + "|drift| [u/step]");
    }
    // Nearly periodic: what twenty periods show is all there is.
    figures::at_most(1.1 * errors.swing, E.worst, name + ": the energy error stays what it is in 20 periods",
                     which + "max |dH/H|");
    figures::at_most(5, std::abs(E.t), name + ": H does not drift", which + "|t| of Student's test");
  };
  check("midpoint", phistep::midpoint, 400, 1e6);
  check("Verlet", phistep::velocity_verlet, 400, 1e7);
  check("SRKN6b", phistep::srkn6b, 200, 5e6);
  check("SRKN11b", phistep::srkn11b, 200, 5e6);
  const auto soon = follow("midpoint, first", phistep::midpoint, 400, 102400);
  figures::at_most(1e-12, soon.momentum.worst(), "midpoint keeps the angular momentum", "1e5 steps: max |dL/L|");
}

TEST_CASE("Kepler: Brouwer's law, and what compensated sums make of it") {
  // 200 steps a period: the method itself is far below rounding.
  const double steps = 4096000;
  const auto check = [&](const std::string& name, auto scheme) {
    const auto errors = follow(name, scheme, 200, steps);
    const auto E = errors.energy.trend();
    figures::told(E.worst, name, "4e6 steps: max |dH/H|");
    figures::told(E.slope / u, name, "drift of H [u/step]");
    figures::told(E.exponent, name, "exponent of the energy error");
    figures::told(errors.time.worst(), name, "4e6 steps, 2e4 periods: late by [period/2 pi]");
    figures::told(errors.time.exponent(2), name, "exponent of the time error");
    return E;
  };
  const auto plain = check("RKN12(10)", phistep::rkn1210),
             exact = check("RKN12(10), compensated", phistep::compensated(phistep::rkn1210));
  figures::at_most(5, std::abs(exact.t), "RKN12(10), compensated: H does not drift", "|t| of Student's test");
  figures::at_most(0.2, exact.worst / plain.worst, "compensated sums pay", "max |dH/H|, over that without");
  std::vector<double> ratios;
  for (int k = 0; k < 9; ++k) {
    const double one = seconds_of(phistep::rkn1210, 30000);
    ratios.push_back(seconds_of(phistep::compensated(phistep::rkn1210), 30000) / one);
  }
  std::sort(ratios.begin(), ratios.end());
  figures::told(ratios[4], "compensated sums cost", "CPU time ratio on Kepler, median of 9");
}
