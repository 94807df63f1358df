// A star cluster of 1500 stars in equilibrium, Plummer's sphere, for ten crossing times: it should stay what it is.
//
// Every star pulls at every other, softened at close range, with velocity Verlet. In N-body units (G = 1, mass 1, energy
// −1/4) Plummer's density is (1 + r²/a²)^(−5/2) with a = 3π/16; half the mass is within 0.77, a star crosses the cluster in
// about 2√2. The Lagrangian radii, within which there are 10, 25, 50, 75 and 90 % of the mass, stay level but for the noise
// of 1500 stars. Energy wavers by what Δt² makes of close encounters, but doesn't drift; momentum is kept to rounding.
//
// Run: plummer [--short] [--out DIR] [--stars STARS]
// Frames: plummer.xyz opens in OVITO and ASE                  Picture: python3 plot/plot_plummer.py [DIR]
#include <phistep/io.hpp>
#include <phistep/particles.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <numbers>
#include <vector>

#include "command_line.hpp"
#include "plummer.hpp"
#include "progress.hpp"

using Stars = phistep::Particles<double, 3>;
constexpr double core_length = 3 * std::numbers::pi / 16;  // Plummer's length in N-body units

int main(int argc, char** argv) {
  CommandLine options(argc, argv, {{"--stars", ""}});
  Stars stars = plummer_sphere(options.whole("--stars", options.is_short ? 250 : 1500, 10));
  const double dt = 0.01, crossing = 2 * std::sqrt(2), t1 = options.is_short ? 0.5 : 10 * crossing;

  const phistep::AllPairs gravity{phistep::SoftenedGravity{.G = 1, .epsilon = 0.05}};
  phistep::PhiStepper stepper{stars, gravity, phistep::velocity_verlet};
  phistep::EnergyLedger ledger{stepper};

  constexpr std::array shares{0.1, 0.25, 0.5, 0.75, 0.9};
  auto curves = options.file("plummer.csv"), frames = options.file("plummer.xyz");
  curves << "t,energy_error,r10,r25,r50,r75,r90\n";
  std::vector<double> half_mass;
  const auto look = [&](double t, const Stars& y) {
    // About the median star, which doesn't follow those that leave.
    Eigen::Vector3d centre;
    for (int k = 0; k < 3; ++k) {
      std::vector<double> x(y.r.row(k).begin(), y.r.row(k).end());
      std::nth_element(x.begin(), x.begin() + y.size() / 2, x.end());
      centre[k] = x[std::size_t(y.size() / 2)];
    }
    Eigen::VectorXd distance = (y.r.colwise() - centre).colwise().norm();
    std::sort(distance.begin(), distance.end());
    curves << t << ',' << ledger.energy() / ledger.start() - 1;
    for (const double share : shares) curves << ',' << distance[Eigen::Index(share * double(y.size()))];
    curves << '\n';
    half_mass.push_back(distance[y.size() / 2]);
  };
  const Eigen::Vector3d momentum = phistep::momentum(stars), turning = phistep::angular_momentum(stars);
  std::printf("%ld stars, %.1f crossing times in steps of %g\n", long(stars.size()), t1 / crossing, dt);
  const std::clock_t began = std::clock();
  const auto report =
      phistep::integrate(stepper, stars, {0, t1}, phistep::fixed(dt), ledger, progress(t1), phistep::every(0.1, look),
                         phistep::every(t1 / 10, phistep::extended_xyz(frames)));
  const double seconds = double(std::clock() - began) / CLOCKS_PER_SEC;
  std::cout << report << ledger;
  const double calls = double(report.statistics.force_calls + ledger.force_calls()), n = double(stars.size());
  std::printf(
      "%.2f G interactions/s. Energy %.5f (Plummer: -0.25) changed by %.1e of itself, momentum by %.1e,\n"
      "angular momentum by %.1e of itself. The half-mass radius went from %.3f to %.3f (Plummer: %.3f).\n",
      1e-9 * calls * n * n / seconds, ledger.start(), ledger.energy() / ledger.start() - 1,
      (phistep::momentum(stars) - momentum).norm(),
      (phistep::angular_momentum(stars) - turning).norm() / turning.norm(), half_mass.front(), half_mass.back(),
      core_length / std::sqrt(std::pow(0.5, -2.0 / 3) - 1));
  return report ? 0 : 1;
}
