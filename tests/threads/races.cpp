// All loops that threads share, for a race detector to watch: run under ThreadSanitizer by the long tests. With an argument
// it runs a loop that has a race, which a detector that works must report.
#include <omp.h>
#include <phistep/particles.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>
#include <vector>

using namespace phistep;

namespace {

/// n³ bodies on a lattice, shaken.
template <class P>
P lattice(int n, double distance, double shake) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, shake);
  Eigen::Matrix3Xd r(3, n * n * n), v(3, n * n * n);
  for (Eigen::Index k = 0; k < r.cols(); ++k) {
    r.col(k) << static_cast<double>(k % n), static_cast<double>(k / n % n), static_cast<double>(k / (n * n));
    for (int b = 0; b < 3; ++b) v(b, k) = normal(random);
  }
  return P{Eigen::Matrix3Xd{distance * r}, v};
}
/// Steps with two, three and four threads; true if all succeed.
template <class P, class Make>
bool steps(const char* what, const P& start, int count, double dt, Make make) {
  bool good = true;
  for (const int threads : {2, 3, 4}) {
    omp_set_num_threads(threads);
    P y = start;
    auto stepper = make(y);
    for (int n = 0; n < count; ++n) good = static_cast<bool>(stepper.step(y, n * dt, dt)) && good;
  }
  std::printf("%s: %s\n", what, good ? "stepped" : "FAILED");
  return good;
}
using Atoms = Particles<double, 3>;
using Grains = Particles<double, 3, Spin>;

[[gnu::noinline]] double racy(int n) {
  double sum = 0;
#pragma omp parallel for
  for (int k = 0; k < n; ++k) sum += k;
  return sum;
}

}  // namespace

int main(int argc, char**) {
  if (argc > 1) {
    omp_set_num_threads(4);
    std::printf("a race: %g\n", racy(100000));
    return 0;
  }
  bool good = true;
  const double a = std::cbrt(1 / 0.8442);
  Atoms fluid = lattice<Atoms>(11, a, 1.2);
  fluid.set_box(Box<double, 3>::periodic(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(11 * a)));
  good &= steps("pairs, lists", fluid, 60, 0.004, [](const Atoms& y) {
    return PhiStepper{y, Pairs{LennardJones{}, 2.2, {.skin = 0.2}}, velocity_verlet};
  });
  // So many that threads share the passes over particles and the sorting into cells, too.
  constexpr int m = 29;
  Atoms sea = lattice<Atoms>(m, a, 1.2);
  sea.set_box(Box<double, 3>::periodic(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(m * a)));
  good &= steps("pairs, passes, cells", sea, 8, 0.004, [](const Atoms& y) {
    return PhiStepper{y, Pairs{LennardJones{}, 1.2, {.skin = 0.1}}, velocity_verlet};
  });
  good &= steps("pairs, implicit", fluid, 3, 0.01, [](const Atoms& y) {
    return PhiStepper{y, Pairs{LennardJones{}, 1.8, {.skin = 0.2}}, trapezoidal, newton({.rtol = 1e-6, .atol = 1e-9})};
  });
  Atoms stars = lattice<Atoms>(9, 1, 0.1);
  stars.set_mass(1e-3);
  good &= steps("all pairs", stars, 5, 0.01, [](const Atoms& y) {
    return PhiStepper{y, AllPairs{SoftenedGravity{1.0, 0.1}}, velocity_verlet};
  });
  Grains grains = lattice<Grains>(16, 0.98, 0.5);
  grains.set_radius(0.5).set_box({{0, 0, 0}, {16 * 0.98, 16 * 0.98, 16 * 0.98}, {true, true, false}});
  good &= steps("contacts, walls", grains, 60, 1e-3, [](const Grains& y) {
    const Hooke law{.stiffness = 1e4, .restitution = 0.6, .friction = 0.4, .rolling_friction = 0.1};
    return PhiStepper{y,
                      Contact{law} + Walls<Hooke>{law, Plane<3>{{0, 0, -0.49}, Eigen::Vector3d::UnitZ()}} +
                          Gravity{Eigen::Vector3d{3, 0, -9}},
                      symplectic_euler};
  });
  std::vector<Spring> springs;
  constexpr int n = 16;
  for (int k = 0; k < n * n * n; ++k)
    for (const int to : {1, n, n * n})
      if (k / to % n + 1 < n) springs.push_back({k, k + to, 100, 0.9});
  good &= steps("springs in rows", lattice<Atoms>(n, 1, 0.1), 20, 0.01, [&](const Atoms& y) {
    return PhiStepper{y, spring_network<3>(springs), velocity_verlet};
  });
  std::vector<std::ptrdiff_t> name(n * n * n);
  std::iota(name.begin(), name.end(), 0);
  std::shuffle(name.begin(), name.end(), std::mt19937(2));
  for (Spring& s : springs) s.i = name[static_cast<std::size_t>(s.i)], s.j = name[static_cast<std::size_t>(s.j)];
  good &= steps("springs in rows, particles numbered anyhow", lattice<Atoms>(n, 1, 0.1), 20, 0.01, [&](const Atoms& y) {
    return PhiStepper{y, spring_network<3>(springs), velocity_verlet};
  });
  return good ? 0 : 1;
}
