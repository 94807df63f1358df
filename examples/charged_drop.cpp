// A drop of 2000 ions: Lennard-Jones forces between near ones at every inner step, Coulomb forces of all pairs once in k.
//
// The Coulomb force of all pairs costs five times what the near ones do, and changes ten times as slowly. With
// seldom(k, charges) it is called once in k inner steps (r-RESPA): symplectic and of order 2 as velocity Verlet is, the same
// error of the energy, a quarter of the time for k = 8. Too long an outer step resonates with the fast motion: preflight says
// where that begins, for 60 of the ions.
//
// Run: charged_drop [--short] [--out DIR] [--ions N]
#include <phistep/particles.hpp>
#include <phistep/phistep.hpp>
#include <phistep/preflight.hpp>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <random>
#include <stdexcept>

#include "command_line.hpp"

using Ions = phistep::Particles<double, 3>;

/// n ions of charge ±½ on a cubic lattice a little wider than Lennard-Jones' distance of rest, at a temperature of 0.4.
Ions drop_of(Eigen::Index n) {
  const auto edge = static_cast<Eigen::Index>(std::ceil(std::cbrt(static_cast<double>(n))));
  Eigen::Matrix3Xd r(3, n);
  Eigen::VectorXd q(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index x = i % edge, y = i / edge % edge, z = i / (edge * edge);
    r.col(i) << 1.1 * double(x), 1.1 * double(y), 1.1 * double(z);
    q[i] = (x + y + z) % 2 == 0 ? 0.5 : -0.5;
  }
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, std::sqrt(0.4));
  Eigen::Matrix3Xd v = Eigen::Matrix3Xd::NullaryExpr(3, n, [&] { return normal(random); });
  v.colwise() -= v.rowwise().mean().eval();
  Ions ions{r, v};
  ions.set_charge(q);
  return ions;
}

int main(int argc, char** argv) {
  CommandLine options(argc, argv, {{"--ions", ""}});
  const Ions start = drop_of(options.whole("--ions", options.is_short ? 200 : 2000, 8));
  const double h = 0.004;  // of an inner step, in Lennard-Jones' units
  const int steps = options.is_short ? 96 : 480;
  const phistep::Pairs near_ones{phistep::LennardJones{}.shifted(2.5), 2.5};
  const phistep::AllPairs charges{phistep::Coulomb{.k = 1, .epsilon = 0.1}};

  std::puts("  k   Coulomb calls   seconds   largest error of the energy / kinetic");
  for (const int k : {1, 2, 4, 8, 16}) {
    Ions ions = start;
    phistep::PhiStepper stepper{ions, near_ones + phistep::seldom(k, charges), phistep::velocity_verlet};
    const auto energy = [&] { return ions.v.squaredNorm() / 2 + phistep::potential_energy(stepper, ions); };
    const double before = energy();
    double worst = 0, seconds = 0;
    for (int n = 0; n < steps / k; ++n) {
      const std::clock_t began = std::clock();
      if (const auto report = stepper.step(ions, n * k * h, k * h); !report) throw std::runtime_error(report.message());
      seconds += double(std::clock() - began) / CLOCKS_PER_SEC;
      if ((n + 1) * k % 16 == 0) worst = std::max(worst, std::abs(energy() - before));
    }
    std::printf(" %2d   %13ld   %7.2f   %.1e\n", k, long(stepper.calls_by_term()[1]), seconds,
                worst / (ions.v.squaredNorm() / 2));
  }

  Ions few = drop_of(60);
  phistep::PhiStepper stepper{few, near_ones + phistep::seldom(8, charges), phistep::velocity_verlet};
  std::cout << "\nOf 60 ions, k = 8:\n" << phistep::preflight(stepper, few, 8 * h);
  return 0;
}
