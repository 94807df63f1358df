// A crystal of 10,976 argon atoms melts: Lennard-Jones forces in a periodic box, velocity Verlet, nothing but energy kept.
//
// Lengths are in σ = 3.405 Å, energies in ε = 119.8 K·k_B, times in τ = σ√(m/ε) = 2.156 ps. The density 0.8442 is that of
// liquid argon at its triple point, 83.8 K. The crystal gets twice that temperature; melting takes half of it away, because
// kinetic energy becomes potential energy. The radial distribution function g(r) tells solid from liquid: peaks at the
// lattice's distances at first, then shells that fade out.
//
// Run: argon_melt [--short] [--out DIR] [--cells CELLS]       (4 CELLS³ atoms)
// Frames: argon_melt.xyz opens in OVITO and ASE, argon_melt.vtk.series in ParaView and PyVista
// Picture: python3 plot/plot_argon_melt.py [DIR]
#include <phistep/io.hpp>
#include <phistep/particles.hpp>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <numbers>
#include <random>

#include "command_line.hpp"
#include "progress.hpp"

using Atoms = phistep::Particles<double, 3>;
constexpr double sigma = 3.405, epsilon = 119.8, tau = 2.156;  // [Å], [K·k_B], [ps]

/// A face-centred cubic crystal of 4 n³ atoms with velocities of a temperature and without a common drift.
Atoms crystal(Eigen::Index n, double density, double temperature) {
  const double a = std::cbrt(4 / density);
  const Eigen::Matrix<double, 3, 4> corners{{0, 0, 0.5, 0.5}, {0, 0.5, 0, 0.5}, {0, 0.5, 0.5, 0}};
  Eigen::Matrix3Xd r(3, 4 * n * n * n);
  for (Eigen::Index k = 0; k < r.cols(); ++k)
    r.col(k) =
        a * (corners.col(k % 4) + Eigen::Vector3d(double(k / 4 % n), double(k / 4 / n % n), double(k / 4 / n / n)));
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0, std::sqrt(temperature));
  Eigen::Matrix3Xd v = r.unaryExpr([&](double) { return normal(random); });
  v.colwise() -= Eigen::Vector3d(v.rowwise().mean());
  Atoms atoms{r, v};
  atoms.set_box(phistep::Box<double, 3>::periodic(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(a * double(n))));
  return atoms;
}

/// g(r): how many others are at a distance, relative to an ideal gas; up to r = 5 in steps of 0.02.
Eigen::VectorXd radial_distribution(const Atoms& y) {
  constexpr double width = 0.02, reach = 5;
  Eigen::VectorXd count = Eigen::VectorXd::Zero(Eigen::Index(reach / width));
  const Eigen::Index centres = std::min<Eigen::Index>(y.size(), 1000);
  for (Eigen::Index i = 0; i < centres; ++i)
    for (Eigen::Index j = 0; j < y.size(); ++j) {
      const double r2 = y.box().nearest(y.r.col(i) - y.r.col(j)).squaredNorm();
      if (i != j && r2 < reach * reach) count[std::min(count.size() - 1, Eigen::Index(std::sqrt(r2) / width))] += 1;
    }
  const double density = double(y.size()) / y.box().length().prod();
  for (Eigen::Index k = 0; k < count.size(); ++k) {
    const double shell =
        4 * std::numbers::pi / 3 * (std::pow(double(k + 1), 3) - std::pow(double(k), 3)) * std::pow(width, 3);
    count[k] /= double(centres) * density * shell;
  }
  return count;
}

int main(int argc, char** argv) {
  CommandLine options(argc, argv, {{"--cells", ""}});
  Atoms atoms = crystal(options.whole("--cells", options.is_short ? 5 : 14, 4), 0.8442, 1.44);
  const double dt = 0.005, t1 = options.is_short ? 0.25 : 10;  // 11 fs, 21.6 ps

  const double cutoff = 2.5;
  const phistep::Pairs argon{phistep::LennardJones{}.shifted(cutoff), cutoff};
  phistep::PhiStepper stepper{atoms, argon, phistep::velocity_verlet};
  phistep::EnergyLedger ledger{stepper};
  auto series = phistep::vtk_series(options.out / "argon_melt", {.wrapped = true, .single = true});

  auto curves = options.file("argon_melt.csv"), shells = options.file("argon_melt_gr.csv"),
       frames = options.file("argon_melt.xyz");
  curves << "t_ps,temperature_K,kinetic,potential,energy\n";
  shells << "t_ps,r_A,g\n";
  const double n = double(atoms.size());
  const auto look = [&](double t, const Atoms& y) {
    curves << t * tau << ',' << epsilon * phistep::temperature(y) << ',' << ledger.kinetic() / n << ','
           << ledger.potential() / n << ',' << ledger.energy() / n << '\n';
  };
  const auto write_shells = [&](double t, const Atoms& y) {
    const Eigen::VectorXd g = radial_distribution(y);
    for (Eigen::Index k = 0; k < g.size(); ++k)
      shells << t * tau << ',' << sigma * 0.02 * (double(k) + 0.5) << ',' << g[k] << '\n';
  };
  std::printf("%ld atoms, %g ps in steps of %.0f fs; %.1f K\n", long(atoms.size()), t1 * tau, 1e3 * dt * tau,
              epsilon * phistep::temperature(atoms));
  const std::clock_t began = std::clock();
  const auto report =
      phistep::integrate(stepper, atoms, {0, t1}, phistep::fixed(dt), ledger, progress(t1), phistep::every(0.02, look),
                         phistep::every(t1 / 10, write_shells),
                         phistep::every(t1 / 5, phistep::extended_xyz(frames, {.species = {"Ar"}, .wrapped = true})),
                         phistep::sampled(t1 / 20, series));
  const double seconds = double(std::clock() - began) / CLOCKS_PER_SEC;
  std::cout << report << ledger;
  std::printf("%.2f million atom-steps/s, %g neighbour lists. It is %.1f K warm; energy changed by %.1e of itself.\n",
              1e-6 * n * double(report.statistics.steps) / seconds, double(stepper.force_to_look_at().rebuilds()),
              epsilon * phistep::temperature(atoms), ledger.energy() / ledger.start() - 1);
  return report ? 0 : 1;
}
