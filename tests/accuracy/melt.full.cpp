// The Lennard-Jones melt of LAMMPS' own benchmark: its printed thermo, and the energy over a long run.
#include <phistep/particles.hpp>

#include <cmath>
#include <cstdio>
#include <string>

#include "../../bench/particles/scene.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Atoms = Particles<double, 3>;

namespace {

Atoms melt(int cells) {
  const bench::Scene scene = bench::melt_start(cells);
  Atoms atoms{scene.r, scene.v};
  atoms.set_box(Box<double, 3>::periodic(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(scene.side)));
  return atoms;
}
/// As LAMMPS prints it: eight digits.
std::string digits(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.8g", x);
  return text;
}

}  // namespace

TEST_CASE("temperature, energies and pressure of 32,000 atoms are LAMMPS' to the last digit that it prints") {
  // LAMMPS 20210929 (Debian 12) on the same start, `neigh_modify delay 0 every 1 check yes`, r_c = 2.5, Δt = 0.005:
  //   Step Temp E_pair E_mol TotEng Press
  //      0 1.44        -6.7733681 0 -4.6134356 -5.0197073
  //    100 0.76065902  -5.763303  0 -4.6223501  0.19440137
  Atoms atoms = melt(20);
  REQUIRE(atoms.size() == 32000);
  PhiStepper stepper{atoms, Pairs{LennardJones{}, 2.5}, velocity_verlet};
  const auto check = [&](const char* t, const char* pair, const char* total, const char* p) {
    const double n = static_cast<double>(atoms.size()), potential = potential_energy(stepper, atoms);
    CHECK(digits(temperature(atoms)) == t);
    CHECK(digits(potential / n) == pair);
    CHECK(digits((potential + kinetic_energy(atoms)) / n) == total);
    CHECK(digits(pressure(stepper, atoms)) == p);
  };
  check("1.44", "-6.7733681", "-4.6134356", "-5.0197073");
  for (int n = 0; n < 100; ++n) REQUIRE(stepper.step(atoms, 0.005 * n, 0.005));
  check("0.76065902", "-5.763303", "-4.6223501", "0.19440137");
  CHECK(stepper.statistics().force_calls == 101);
}

namespace {
/// Lennard-Jones less its value and slope at the cutoff: V − V_c + ½ g_c (r² − r_c²), F/r = g − g_c. Cut off plainly, the
/// force jumps by 0.039 ε/σ at r_c = 2.5, and the energy of the melt then falls by 3e-6 ε per atom and unit of time.
struct Smooth {
  LennardJones lj;
  double cutoff_squared = 2.5 * 2.5;
  auto operator()(auto r2) const { return lj(r2) - lj(cutoff_squared); }
  auto energy(auto r2) const {
    return lj.energy(r2) - lj.energy(cutoff_squared) + 0.5 * lj(cutoff_squared) * (r2 - cutoff_squared);
  }
};

/// The largest |E − E₀| per atom, and the slope of a straight line through E(t), over so many steps.
void check_energy(int steps) {
  Atoms atoms = melt(4);  // 256 atoms
  PhiStepper stepper{atoms, Pairs{Smooth{}, 2.5}, velocity_verlet};
  for (int n = 0; n < 500; ++n) REQUIRE(stepper.step(atoms, 0.005 * n, 0.005));
  const double E0 = potential_energy(stepper, atoms) + kinetic_energy(atoms);
  double largest = 0, sum_tE = 0;
  const int looks = steps / 100;
  for (int n = 0; n < steps; ++n) {
    REQUIRE(stepper.step(atoms, 0.005 * n, 0.005));
    if (n % 100 != 99) continue;
    const double dE = potential_energy(stepper, atoms) + kinetic_energy(atoms) - E0, t = n / 100 - (looks - 1) / 2.0;
    largest = std::max(largest, std::abs(dE));
    sum_tE += t * dE;
  }
  const double slope = 12 * sum_tE / (static_cast<double>(looks) * looks * looks);  // per look
  INFO("largest " << largest / 256 << " per atom, drift over the run " << slope * looks / 256);
  // What Verlet's own energy differs from E swings by 4e-4 at this Δt, and doesn't drift: a line through fewer swings slopes more.
  CHECK(largest / 256 < 1e-3);
  CHECK(std::abs(slope * looks) / 256 < (steps < 10000 ? 2e-4 : 2e-5));
  CHECK(momentum(atoms).norm() < 1e-10);
}
}  // namespace

TEST_CASE("the melt's energy stays where it is") { check_energy(2000); }
TEST_CASE("… for 100,000 steps", "[.long]") { check_energy(100000); }
