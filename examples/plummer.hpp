#pragma once

// A star cluster in equilibrium: Plummer's sphere, ρ ∝ (1 + r²/a²)^(−5/2), sampled as in S. J. Aarseth, M. Hénon,
// R. Wielen, Astron. Astrophys. 37 (1974) 183, in N-body units: G = 1, total mass 1, energy −1/4 (potential −1/2,
// kinetic 1/4), which makes a = 3π/16 and the crossing time 2√2.

#include <phistep/particles/bodies/particles.hpp>
#include <phistep/particles/pairs/all_pairs.hpp>

#include <cmath>
#include <cstdint>
#include <random>
#include <tuple>

/// n stars of equal mass, at rest as a whole. The same seed gives the same cluster everywhere, to the rounding of the C library.
[[nodiscard]] inline phistep::Particles<double, 3> plummer_sphere(Eigen::Index n, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  // In (0, 1), by the generator's own bits: distributions differ between standard libraries.
  const auto uniform = [&random] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  const auto direction = [&uniform]() -> Eigen::Vector3d {
    const double z = 2 * uniform() - 1, turn = 2 * std::acos(-1.0) * uniform(), rho = std::sqrt(1 - z * z);
    return {rho * std::cos(turn), rho * std::sin(turn), z};
  };
  Eigen::Matrix3Xd r(3, n), v(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    // The mass inside r is (1 + 1/r²)^(−3/2), r in units of a; the outermost 1 ‰, which reaches to infinity, is left out.
    const double radius = 1 / std::sqrt(std::pow(0.999 * uniform(), -2.0 / 3) - 1);
    r.col(i) = radius * direction();
    // v = q · escape velocity, q distributed as q² (1 − q²)^(7/2) < 0.1: by rejection.
    double q = uniform(), height = uniform();
    while (0.1 * height > q * q * std::pow(1 - q * q, 3.5)) q = uniform(), height = uniform();
    v.col(i) = q * std::sqrt(2.0) * std::pow(1 + radius * radius, -0.25) * direction();
  }
  r.colwise() -= r.rowwise().mean().eval();
  v.colwise() -= v.rowwise().mean().eval();
  phistep::Particles<double, 3> cluster{r, v};
  cluster.set_mass(1 / static_cast<double>(n));
  if (n < 2) return cluster;
  // To −1/2 and 1/4 exactly, where the sample's are right within some n^(−½).
  const auto masses = phistep::Particles<double, 3>::masses(cluster);
  const double V = phistep::AllPairs{phistep::SoftenedGravity{1, 0}}.energy(
      0.0, phistep::Particles<double, 3>::view(cluster, masses));
  cluster.r *= V / -0.5;
  cluster.v *= std::sqrt(0.25 / (0.5 * cluster.v.squaredNorm() / static_cast<double>(n)));
  return cluster;
}
