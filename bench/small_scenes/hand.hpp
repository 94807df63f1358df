/// @file
/// The small scenes by hand: each loop is written for its one case and checks, as phistep does, that each step is finite
/// before it becomes the state. phistep is not used here.
#pragma once

#include <Eigen/Core>

#include <cmath>

#include <vector>

namespace small_scenes {

/// One particle on a spring, Ψ(r) = −r, of mass `mass`.
struct Particle {
  Eigen::Vector3d r, v;
};
[[nodiscard]] Particle euler(Particle y, double mass, double dt, long steps);
[[nodiscard]] Particle verlet(Particle y, double mass, double dt, long steps);

/// Beads tied by springs, pulled along x. [3 numbers a bead, bead by bead]
struct Net {
  struct Tie {
    Eigen::Index i, j;
    double stiffness, length;
  };
  std::vector<Tie> ties;
  double pull;
};
struct Beads {
  Eigen::VectorXd r, v;
};
/// f += Ψ(r)
inline void add_forces(const Net& net, const double* r, double* f, Eigen::Index n) {
  for (Eigen::Index i = 0; i < n; i += 3) f[i] += net.pull;
  for (const Net::Tie& tie : net.ties) {
    const Eigen::Index i = 3 * tie.i, j = 3 * tie.j;
    const double d[] = {r[j] - r[i], r[j + 1] - r[i + 1], r[j + 2] - r[i + 2]};
    const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const double tension = tie.stiffness * (length - tie.length) / length;
    for (int a = 0; a < 3; ++a) {
      f[i + a] += tension * d[a];
      f[j + a] -= tension * d[a];
    }
  }
}
[[nodiscard]] Beads euler(const Beads& y, const Net& net, double mass, double dt, long steps);
[[nodiscard]] Beads verlet(const Beads& y, const Net& net, double mass, double dt, long steps);

}  // namespace small_scenes
