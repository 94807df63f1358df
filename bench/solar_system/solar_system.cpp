// The outer solar system over 10⁵ years: time, and what becomes of the energy. Its relative error is fitted by a straight
// line through a thousand samples: a slope is a drift, the scatter about it is rounding (a random walk, ∝ √steps) or, for
// symplectic schemes, their own bounded oscillation.
//
//     bench_solar_system [years]
//
// Rivals of other packages are not run here: of REBOUND, on another machine, is known (CPU seconds) IAS15 9.7, at rounding
// level; leapfrog with Δt = 40 d 0.34 at 2.5e-5; WHFast 0.24 at 1e-5, a scheme for one heavy body alone. The first row is
// that leapfrog, and tells how the machines compare.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "problem.hpp"

namespace {

constexpr double year = 365.25;  // [d]

[[nodiscard]] double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// y ≈ a + b x
struct Line {
  double slope = 0, scatter = 0;
  Line(const std::vector<double>& x, const std::vector<double>& y) {
    const double n = static_cast<double>(x.size());
    double mx = 0, my = 0, xx = 0, xy = 0, rest = 0;
    for (std::size_t k = 0; k < x.size(); ++k) mx += x[k] / n, my += y[k] / n;
    for (std::size_t k = 0; k < x.size(); ++k) xx += (x[k] - mx) * (x[k] - mx), xy += (x[k] - mx) * (y[k] - my);
    slope = xy / xx;
    for (std::size_t k = 0; k < x.size(); ++k) rest += std::pow(y[k] - my - slope * (x[k] - mx), 2);
    scatter = std::sqrt(rest / n);
  }
};

template <class Scheme>
void row(const char* name, Scheme scheme, double dt, double years) {
  constexpr int samples = 1000;
  const Planets force;
  auto y = Planets::start();
  phistep::PhiStepper stepper{y, force, scheme};
  const double steps = std::ceil(years * year / dt / samples);  // from sample to sample
  const long double before = Planets::energy(y);
  std::vector<double> t, error;
  double seconds = 0, worst = 0;
  for (int k = 0; k < samples; ++k) {
    const double from = k * steps * dt, to = (k + 1) * steps * dt, start = cpu_seconds();
    const auto report = phistep::integrate(stepper, y, {from, to}, phistep::fixed(dt));
    seconds += cpu_seconds() - start;
    if (!report) {
      std::printf("%-28s %7.0f  failed: %s\n", name, dt, report.message().c_str());
      return;
    }
    t.push_back(to / (years * year));
    error.push_back(static_cast<double>((Planets::energy(y) - before) / before));
    worst = std::max(worst, std::abs(error.back()));
  }
  const Line line{t, error};
  const double whole = years / (samples * steps * dt / year);
  std::printf("%-28s %7.0f %12.3f %13.2e %14.1e %14.1e %14.1e\n", name, dt, seconds * whole * 1e5 / years,
              static_cast<double>(stepper.statistics().force_calls) * whole, worst, std::abs(line.slope), line.scatter);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace phistep;
  const double years = argc > 1 ? std::atof(argv[1]) : 1e5;
  if (!(years > 0)) return 1;
  std::printf("outer solar system, %g years\n\n%-28s %7s %12s %13s %14s %14s %14s\n", years, "", "dt [d]",
              "s/1e5 years", "force calls", "max |dE/E|", "drift of dE/E", "scatter");
  row("velocity Verlet", velocity_verlet, 40, years);
  for (const double dt : {200.0, 100.0}) row("SRKN6b", srkn6b, dt, years);
  for (const double dt : {300.0, 150.0, 75.0}) row("SRKN11b", srkn11b, dt, years);
  for (const double dt : {300.0, 150.0}) row("Kahan-Li 8", composed(velocity_verlet), dt, years);
  for (const double dt : {200.0, 100.0, 50.0}) row("RKN8(6)", rkn86, dt, years);
  for (const double dt : {600.0, 500.0, 400.0, 300.0, 200.0, 150.0}) row("RKN12(10)", rkn1210, dt, years);
  for (const double dt : {300.0, 200.0, 150.0}) row("RKN12(10), compensated", compensated(rkn1210), dt, years);
}
