// One thread or two: the same bits, explicit and implicit, over long runs and through neighbour lists made anew.
#include <omp.h>
#include <phistep/particles.hpp>

#include <cmath>
#include <random>

#include "support/catch.hpp"

using namespace phistep;
using Atoms = Particles<double, 3>;

namespace {

/// A fluid of n³ atoms at LAMMPS' melt's density and temperature, periodic.
Atoms fluid(int n) {
  const double a = std::cbrt(1 / 0.8442);
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1.2);
  Eigen::Matrix3Xd r(3, n * n * n), v(3, n * n * n);
  for (Index k = 0; k < r.cols(); ++k) {
    r.col(k) << static_cast<double>(k % n), static_cast<double>(k / n % n), static_cast<double>(k / (n * n));
    for (int b = 0; b < 3; ++b) v(b, k) = normal(random);
  }
  Atoms atoms{a * r, v.colwise() - v.rowwise().mean()};
  atoms.set_box(Box<double, 3>::periodic(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(n * a)));
  return atoms;
}

/// The end of `steps` steps with so many threads.
template <class Make>
Atoms run(int threads, Atoms atoms, int steps, double dt, Make make) {
  omp_set_num_threads(threads);
  auto stepper = make(atoms);
  for (int n = 0; n < steps; ++n) {
    const StepReport report = stepper.step(atoms, dt * n, dt);
    if (!report) FAIL(report.message());
  }
  return atoms;
}
template <class Make>
void check(const Atoms& start, int steps, double dt, Make make) {
  const Atoms one = run(1, start, steps, dt, make);
  for (const int threads : {2, 3}) {
    const Atoms more = run(threads, start, threads == 2 ? steps : steps / 10, dt, make);
    const Atoms same = threads == 2 ? one : run(1, start, steps / 10, dt, make);
    CHECK(more.r == same.r);
    CHECK(more.v == same.v);
  }
}

}  // namespace

TEST_CASE("Lennard-Jones by velocity Verlet, 10,000 steps") {
  // 1331 rows are three chunks: two threads share them.
  check(fluid(11), 10000, 0.004, [](const Atoms& y) {
    return PhiStepper{y, Pairs{LennardJones{}, 2.2, {.skin = 0.4}}, velocity_verlet};
  });
}

TEST_CASE("Lennard-Jones by the trapezoidal rule: Newton, conjugate gradients, the list as their pattern") {
  check(fluid(9), 40, 0.02, [](const Atoms& y) {
    return PhiStepper{y, Pairs{LennardJones{}, 1.8, {.skin = 0.4}}, trapezoidal, newton({.rtol = 1e-6, .atol = 1e-9})};
  });
}

// Minutes long: acceptance_threads "[long]"
TEST_CASE("over 10,000 steps, explicit and implicit", "[.long]") {
  check(fluid(11), 10000, 0.004, [](const Atoms& y) {
    return PhiStepper{y, Pairs{LennardJones{}, 2.2, {.skin = 0.4}}, velocity_verlet};
  });
  check(fluid(9), 10000, 0.02, [](const Atoms& y) {
    return PhiStepper{y, Pairs{LennardJones{}, 1.8, {.skin = 0.4}}, trapezoidal, newton({.rtol = 1e-6, .atol = 1e-9})};
  });
}

TEST_CASE("gravity among all") {
  Atoms stars = fluid(9);
  stars.set_box(Box<double, 3>::open()).set_mass(1e-3);
  check(stars, 40, 0.01, [](const Atoms& y) {
    return PhiStepper{y, AllPairs{SoftenedGravity{1.0, 0.1}}, velocity_verlet};
  });
}
