// One thread or two: the same bits, through neighbour lists made anew. Implicit, and over long runs: the stress tier.
#include <phistep/particles.hpp>

#include <omp.h>
#include <cmath>
#include <functional>
#include <random>
#include <string>

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

/// Steps `atoms` so many times. Checks stand outside of the template.
using Steps = std::function<std::string(Atoms& atoms, int steps, double dt)>;
Steps by(auto make) {
  return [make](Atoms& atoms, int steps, double dt) -> std::string {
    auto stepper = make(atoms);
    for (int n = 0; n < steps; ++n)
      if (const StepReport report = stepper.step(atoms, dt * n, dt); !report) return report.message();
    return "";
  };
}
/// The end of `steps` steps with so many threads.
Atoms run(int threads, Atoms atoms, int steps, double dt, const Steps& make) {
  omp_set_num_threads(threads);
  const std::string trouble = make(atoms, steps, dt);
  if (!trouble.empty()) FAIL(trouble);
  return atoms;
}
void check(const Atoms& start, int steps, double dt, const Steps& make) {
  const Atoms one = run(1, start, steps, dt, make);
  for (const int threads : {2, 3}) {
    const Atoms more = run(threads, start, threads == 2 ? steps : steps / 10, dt, make);
    const Atoms same = threads == 2 ? one : run(1, start, steps / 10, dt, make);
    CHECK(more.r == same.r);
    CHECK(more.v == same.v);
  }
}

}  // namespace

#if PHISTEP_FULL

TEST_CASE("Lennard-Jones by velocity Verlet, 300 steps") {
  // 1331 rows are three chunks: two threads share them.
  check(fluid(11), 300, 0.004, by([](const Atoms& y) {
          return PhiStepper{y, Pairs{LennardJones{}, 2.2, {.skin = 0.4}}, velocity_verlet};
        }));
}

TEST_CASE("gravity among all") {
  Atoms stars = fluid(9);
  stars.set_box(Box<double, 3>::open()).set_mass(1e-3);
  check(stars, 40, 0.01, by([](const Atoms& y) {
          return PhiStepper{y, AllPairs{SoftenedGravity{1.0, 0.1}}, velocity_verlet};
        }));
}

TEST_CASE("the energy of all pairs has the same bits with one thread, two and three") {
  Atoms stars = fluid(11);  // several teams of 256
  stars.set_box(Box<double, 3>::open()).set_mass(1e-3);
  const auto energy = [&stars](int threads) {
    omp_set_num_threads(threads);
    const AllPairs gravity{SoftenedGravity{1.0, 0.1}};
    const auto masses = Atoms::masses(stars);
    return gravity.energy(0, Blocks<Atoms>::view(stars, masses));
  };
  const double one = energy(1);
  CHECK(one < 0);
  CHECK(energy(2) == one);
  CHECK(energy(3) == one);
}

TEST_CASE("grains on a floor: contacts, friction and walls of enough of them that threads share each pass") {
  using Grains = Particles<double, 3, Spin>;
  constexpr int side = 17;  // 4913 grains
  Eigen::Matrix3Xd r(3, side * side * side), v(3, r.cols());
  for (Eigen::Index k = 0; k < r.cols(); ++k) {
    const auto at = [k](double x) { return 0.04 * std::sin(x * static_cast<double>(k)); };
    r.col(k) << 0.5 + static_cast<double>(k % side) + at(1), 0.5 + static_cast<double>(k / side % side) + at(2),
        0.48 + 0.98 * static_cast<double>(k / side / side) + at(3);
    v.col(k) << 20 * at(4), 20 * at(5), 20 * at(6);
  }
  const GranHooke law{
      .stiffness = 1e4, .tangential_stiffness = 3e3, .damping = 10, .tangential_damping = 5, .friction = 0.5};
  const auto end = [&](int threads) {
    omp_set_num_threads(threads);
    Grains grains{r, v};
    grains.set_radius(0.5).set_mass(1.0);
    Contact contact{law, 0.02};
    Walls floor{law, Plane<3>{.point = {0, 0, 0}, .normal = {0, 0, 1}}};
    PhiStepper stepper{grains, Gravity{Eigen::Vector3d{0.2, 0, -1}} + term(std::ref(contact)) + term(std::ref(floor)),
                       symplectic_euler};
    for (int n = 0; n < 40; ++n) REQUIRE(stepper.step(grains, 5e-4 * n, 5e-4));
    CHECK(contact.statistics().touching > 2000);
    CHECK(contact.statistics().rebuilds > 1);
    CHECK(floor.touching() > 100);
    return grains;
  };
  const Grains one = end(1);
  for (const int threads : {2, 3, 7}) {
    const Grains more = end(threads);
    CAPTURE(threads);
    CHECK(more.r == one.r);
    CHECK(more.v == one.v);
    CHECK(more.omega == one.omega);
  }
}

#elif PHISTEP_STRESS
// One thread or two: the same bits, implicit and over long runs.

TEST_CASE("Lennard-Jones by velocity Verlet, 10,000 steps") {
  // 1331 rows are three chunks: two threads share them.
  check(fluid(11), 10000, 0.004, by([](const Atoms& y) {
          return PhiStepper{y, Pairs{LennardJones{}, 2.2, {.skin = 0.4}}, velocity_verlet};
        }));
}

TEST_CASE("Lennard-Jones by the trapezoidal rule: Newton, conjugate gradients, the list as their pattern") {
  check(fluid(9), 40, 0.02, by([](const Atoms& y) {
          return PhiStepper{y, Pairs{LennardJones{}, 1.8, {.skin = 0.4}}, trapezoidal,
                            newton({.rtol = 1e-6, .atol = 1e-9})};
        }));
}

// Minutes long: acceptance_threads "[long]"
TEST_CASE("over 10,000 steps, explicit and implicit", "[.long]") {
  check(fluid(11), 10000, 0.004, by([](const Atoms& y) {
          return PhiStepper{y, Pairs{LennardJones{}, 2.2, {.skin = 0.4}}, velocity_verlet};
        }));
  check(fluid(9), 10000, 0.02, by([](const Atoms& y) {
          return PhiStepper{y, Pairs{LennardJones{}, 1.8, {.skin = 0.4}}, trapezoidal,
                            newton({.rtol = 1e-6, .atol = 1e-9})};
        }));
}

#endif
