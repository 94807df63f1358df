// Arenstorf's orbit: a satellite that falls around earth and moon and comes back to where it was, if you compute it well.
//
// It passes the moon at a twelfth of the earth-moon distance, where it takes steps a thousand times shorter than far out. The
// user states an accuracy; the run finds Δt, says which component ruled it, and where. In units of the earth-moon distance
// and of the month over 2π, in the frame that turns with both (Hairer, Nørsett & Wanner, Solving ODEs I, sect. II.0):
//
//     x'' = x + 2y' − μ' (x+μ)/D₁ − μ (x−μ')/D₂,   y'' = y − 2x' − μ' y/D₁ − μ y/D₂,
//     D₁ = ((x+μ)² + y²)^{3/2},   D₂ = ((x−μ')² + y²)^{3/2},   μ = 0.012277471,   μ' = 1 − μ.
//
// The orbit magnifies an error made at its start 10⁴ times: an error at the end of 10⁴ rtol is what the problem allows.
//
// Run: arenstorf [--short] [--out DIR]        Picture: python3 plot/plot_arenstorf.py [DIR]
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdio>
#include <iostream>

#include "command_line.hpp"

using Vec = Eigen::Vector2d;
using Satellite = phistep::Motion<Vec>;

constexpr double mu = 0.012277471, period = 17.0652165601579625588917206249;

Vec acceleration(const Vec& r, const Vec& v) {
  const Vec earth = r + Vec{mu, 0}, moon = r - Vec{1 - mu, 0};
  const double near_earth = std::pow(earth.norm(), 3), near_moon = std::pow(moon.norm(), 3);
  return r + 2 * Vec{v.y(), -v.x()} - (1 - mu) / near_earth * earth - mu / near_moon * moon;
}
Satellite start() { return {Vec{0.994, 0}, Vec{0, -2.00158510637908252240537862224}}; }

int main(int argc, char** argv) {
  const CommandLine options(argc, argv);
  bool as_expected = true;
  std::printf("Verlet, one period, controlled\n%8s %10s %10s %10s %12s %12s\n", "rtol", "steps", "rejected", "miss",
              "shortest dt", "longest dt");
  double previous = 0;
  for (const double rtol : {1e-5, 1e-6, 1e-7, 1e-8}) {
    if (options.is_short && rtol < 1e-7) break;
    Satellite y = start();
    phistep::PhiStepper stepper{y, acceleration, phistep::velocity_verlet};
    const auto report = phistep::integrate(stepper, y, {0, period}, phistep::tolerance{.rtol = rtol, .atol = rtol});
    if (!report) CommandLine::stop(report.message());
    const double miss = (y.r - start().r).norm();
    std::printf("%8.0e %10lld %10lld %10.1e %12.1e %12.1e\n", rtol, static_cast<long long>(report.statistics.steps),
                static_cast<long long>(report.statistics.rejections), miss, report.smallest_dt, report.largest_dt);
    as_expected = as_expected && miss < 1e5 * rtol && (rtol > 1e-6 || miss < previous);
    previous = miss;
  }

  // The same orbit with one Δt: as many steps as the controlled run at 1e-7, and where that leads.
  Satellite y = start();
  phistep::PhiStepper stepper{y, acceleration, phistep::velocity_verlet};
  auto orbit = options.file("arenstorf_orbit.csv");
  orbit << "t,x,y\n";
  auto steps = options.file("arenstorf_steps.csv");
  steps << "t,dt,x,y\n";
  const auto report = phistep::integrate(
      stepper, y, {0, period}, phistep::tolerance{.rtol = 1e-6, .atol = 1e-6},
      phistep::sampled(
          period / 4000,
          [&](double t, const Satellite& now) { orbit << t << ',' << now.r.x() << ',' << now.r.y() << '\n'; }),
      [&](const auto& step) {
        steps << step.t0() << ',' << step.dt() << ',' << step.start().r.x() << ',' << step.start().r.y() << '\n';
      });
  std::cout << "\nrtol = 1e-6: " << report << '\n';

  const auto count = report.statistics.steps;
  Satellite fixed = start();
  const auto lost =
      phistep::integrate(stepper, fixed, {0, period}, phistep::fixed(period / static_cast<double>(count)));
  const double controlled_miss = (y.r - start().r).norm(), fixed_miss = (fixed.r - start().r).norm();
  std::printf("%lld equal steps instead: off by %.1e (controlled: %.1e). %s\n", static_cast<long long>(count),
              fixed_miss, controlled_miss, lost.message().c_str());
  as_expected = as_expected && report && !(fixed_miss < 10 * controlled_miss);
  if (!as_expected) std::printf("This is not the accuracy that was asked for.\n");
  return as_expected ? 0 : 1;
}
