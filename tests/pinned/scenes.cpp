// Scenes of many particles: pairs within a cutoff, all pairs, springs (explicit and implicit), grains on a floor, slow forces
// called seldom.
#include <Eigen/Core>
#include <phistep/particles.hpp>

#include <vector>

#include "pinned/pinned.hpp"
#include "problems/pyramid.hpp"

namespace {

using namespace phistep;
using Eigen::Vector3d;
using Atoms = Particles<double, 3>;

/// side³ atoms of a crystal of Lennard-Jones' density, off their places and moving by amounts that look thrown.
Atoms crystal(Index side) {
  const Index n = side * side * side;
  const double spacing = 1.0625;
  Eigen::Matrix3Xd r(3, n), v(3, n);
  for (Index k = 0; k < n; ++k) {
    r.col(k) << static_cast<double>(k % side), static_cast<double>(k / side % side),
        static_cast<double>(k / (side * side));
    r.col(k) *= spacing;
    for (Index a = 0; a < 3; ++a) {
      r(a, k) += static_cast<double>((7 * k + 11 * a + 3) % 23 - 11) / 256;
      v(a, k) = static_cast<double>((13 * k + 5 * a) % 31 - 15) / 8;
    }
  }
  Atoms y{r, v};
  y.set_box(Box<double, 3>::periodic(Vector3d::Zero(), Vector3d::Constant(spacing * static_cast<double>(side))));
  return y;
}

void scene(const char* name, auto y, const auto& force, const auto& scheme, double dt, int steps) {
  pinned::run(name, [&](pinned::Hash& hash) {
    PhiStepper stepper{y, force, scheme};
    for (int n = 0; n < steps; ++n) pinned::good(stepper.step(y, dt * n, dt));
    hash.add(y);
  });
}

/// A falling rope of n masses, stiff against stretching, less so against bending.
std::vector<Spring> rope(int n) {
  std::vector<Spring> springs;
  for (int i = 0; i + 1 < n; ++i) springs.push_back({i, i + 1, 1000, 1});
  for (int i = 0; i + 2 < n; ++i) springs.push_back({i, i + 2, 10, 2});
  return springs;
}
Atoms rope_start(int n) {
  Eigen::Matrix3Xd r = Eigen::Matrix3Xd::Zero(3, n);
  for (int i = 0; i < n; ++i) r.col(i) << 0.9375 * i, 0.0625 * (i % 3), 0.03125 * (i % 5);
  Atoms y{r};
  y.set_mass(0.5);
  return y;
}

const bool added = pinned::added([] {
  const LennardJones law;
  scene("melt of 1,331 atoms by Verlet", crystal(11), Pairs{law.shifted(2.25), 2.25}, velocity_verlet, 0.00390625, 50);
  Atoms stars = crystal(9);
  stars.set_box(Box<double, 3>::open()).set_mass(0.0078125);
  scene("gravity of 729 stars by Verlet", stars, AllPairs{SoftenedGravity{1.0, 0.125}}, velocity_verlet, 0.0078125, 10);
  scene("melt of 343 atoms by the trapezoidal rule", crystal(7), Pairs{law.shifted(1.75), 1.75}, trapezoidal, 0.0078125,
        4);
  stars = crystal(7);
  stars.set_box(Box<double, 3>::open());
  scene("drop of 343 atoms, gravity called seldom", stars,
        Pairs{law.shifted(1.75), 1.75} + seldom(4, AllPairs{SoftenedGravity{0.03125, 0.5}}), velocity_verlet,
        0.001953125, 20);
  scene("rope of 600 by symplectic Euler", rope_start(600), spring_network<3>(rope(600)) + Gravity{Vector3d{0, 0, -10}},
        symplectic_euler, 0.00390625, 200);
  scene("rope of 600 by backward Euler", rope_start(600),
        spring_network<3>(rope(600), SpringDamping{0.5}) + Gravity{Vector3d{0, 0, -10}}, backward_euler, 0.0625, 20);
  const problems::Pyramid heap{.side = 7, .tilt = 0};
  scene("heap of 140 grains by symplectic Euler", heap.start(), heap.force(), symplectic_euler, 0.00048828125, 400);
});

}  // namespace
