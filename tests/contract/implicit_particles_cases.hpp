#pragma once

// A crystal that the tests of implicit particles share, quick and full.

#include <phistep/particles.hpp>
#include <phistep/particles/pairs/pairs.hpp>

#include <cmath>
#include <cstdlib>

#include "support/catch.hpp"

namespace implicit_particles {

using namespace phistep;
using Atoms = Particles<double, 3>;

/// A warm cubic crystal, periodic: 6³ atoms at the distance of the potential's minimum.
inline Atoms crystal(double heat) {
  const double a = std::pow(2.0, 1.0 / 6);
  constexpr int n = 6;
  Eigen::Matrix3Xd r(3, n * n * n);
  for (Index k = 0; k < r.cols(); ++k)
    r.col(k) << static_cast<double>(k % n), static_cast<double>(k / n % n), static_cast<double>(k / (n * n));
  std::srand(1);
  Atoms atoms{a * r, heat * Eigen::Matrix3Xd::Random(3, r.cols())};
  atoms.v.colwise() -= atoms.v.rowwise().mean().eval();
  atoms.set_box(Box<double, 3>::periodic({0, 0, 0}, {n * a, n * a, n * a}));
  return atoms;
}
inline auto argon() { return Pairs{LennardJones{1.0, 1.0}.shifted(2.5), 2.5}; }
template <class Force>
double energy(Force& force, const Atoms& y) {
  const auto masses = Atoms::masses(y);
  return 0.5 * y.v.squaredNorm() + force.energy(0.0, Atoms::view(y, masses));
}

void check_formula(auto scheme, double phi) {
  Atoms atoms = crystal(0.3);
  const Atoms start = atoms;
  constexpr double dt = 0.02;
  PhiStepper stepper{atoms, argon(), scheme};
  REQUIRE(stepper.step(atoms, 0.0, dt));
  Pairs force = argon();
  const auto psi = [&](const Atoms& y) {
    const auto masses = Atoms::masses(y);
    Atoms::Rate out = make_rate<Atoms>(y);
    NeighborMemory memory;
    force.add(0.0, Atoms::view(y, masses), memory, out);
    return out.force;
  };
  const Eigen::Matrix3Xd mean = phi * psi(atoms) + (1 - phi) * psi(start);
  // Newton stops where rounding does: forces are of the order of 1e2.
  CHECK((atoms.v - start.v - dt * mean).cwiseAbs().maxCoeff() < 1e-12);
  CHECK((atoms.r - start.r - dt * start.v - phi * dt * dt * mean).cwiseAbs().maxCoeff() < 1e-13);
}

}  // namespace implicit_particles
