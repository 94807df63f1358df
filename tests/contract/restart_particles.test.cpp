// Particles, restarted anywhere: neighbour lists go on as they would have. Histories, sleepers, more schemes and
// forces: the full tier.
#include <phistep/particles.hpp>

#include <cmath>
#include <random>

#include "contract/restart.hpp"
#include "support/catch.hpp"

namespace restart_particles {

using namespace phistep;
using restart::check;
using restart::loosely;
using restart::Steps;
using Atoms = Particles<double, 3>;

/// A hot gas, periodic: lists are made every few steps.
inline Atoms gas() {
  constexpr int n = 3;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  Eigen::Matrix3Xd r(3, n * n * n), v(3, n * n * n);
  for (Index k = 0; k < r.cols(); ++k) {
    r.col(k) << 1.3 * static_cast<double>(k % n), 1.3 * static_cast<double>(k / n % n),
        1.3 * static_cast<double>(k / (n * n));
    for (int a = 0; a < 3; ++a) v(a, k) = 2 * normal(random);
  }
  Atoms atoms{r, v};
  atoms.set_mass(2.0).set_box(Box<double, 3>::periodic({0, 0, 0}, {1.3 * n, 1.3 * n, 1.3 * n}));
  return atoms;
}
inline auto lennard_jones() { return Pairs{LennardJones{}, 1.8, {.skin = 0.2}}; }
template <class... More>
auto steps(auto force, More... more) {
  return [=](const Atoms& y) { return PhiStepper{y, force, more...}; };
}

/// Grains that fall on a slope, roll and slide.
using Grains = Particles<double, 3, Spin>;
inline Grains shower() {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> within(-0.1, 0.1);
  Eigen::Matrix3Xd r(3, 12), v(3, 12);
  for (Index k = 0; k < r.cols(); ++k) {
    r.col(k) << static_cast<double>(k % 3), static_cast<double>(k / 3 % 2), 0.45 + 0.95 * static_cast<double>(k / 6);
    for (int a = 0; a < 3; ++a) r(a, k) += within(random), v(a, k) = 5 * within(random);
  }
  Grains grains{r, v};
  grains.set_mass(1.0).set_radius(0.5).set_box({{0, 0, 0}, {6, 6, 6}, {true, true, false}});
  return grains;
}
inline auto on_plane(const Hooke& law, const Eigen::Vector3d& gravity) {
  return Contact{law} + Walls<Hooke>{law, Plane<3>{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()}} +
         Gravity{gravity};
}
inline auto friction() {
  return on_plane({.stiffness = 1e4, .restitution = 0.6, .friction = 0.4, .rolling_friction = 0.1}, {3, 0, -9});
}
/// Four that come to rest one by one, and one that lands beside them when they sleep.
inline Grains calm() {
  Eigen::Matrix3Xd r(3, 5);
  r << 0, 2, 4, 6, 1, 0, 0, 0, 0, 0.2, 0.5, 0.51, 0.52, 0.53, 2.5;
  Grains grains{r};
  grains.set_mass(1.0).set_radius(0.5);
  return grains;
}

}  // namespace restart_particles

using namespace phistep;
using namespace restart_particles;

#if PHISTEP_FULL
// Particles, restarted anywhere: all schemes and forces.

TEST_CASE("contacts go on with the history of their friction") {
  const auto steps_by = [](auto... scheme) {
    return [=](const Grains& y) { return PhiStepper{y, friction(), scheme...}; };
  };
  check({.dt = 1e-3, .count = 400}, shower, steps_by(symplectic_euler));
  check({.dt = 1e-3, .even = false, .count = 200}, shower, steps_by(forward_euler));
}

TEST_CASE("sleepers sleep on") {
  const Statistics work = check({.dt = 1e-3, .count = 1500}, calm, [](const Grains& y) {
    const Hooke law{.stiffness = 1e4, .restitution = 0.1, .friction = 0.9, .rolling_friction = 0.4};
    auto force = Contact{law} + Walls<Hooke>{law, Plane<3>{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()}} +
                 Gravity{Eigen::Vector3d{0, 0, -9}};
    return Sleeping{PhiStepper{y, force, symplectic_euler}, SleepOptions{.speed = 0.02, .steps = 40, .every = 10}};
  });
  CHECK(work.sleeping > 100);
}

TEST_CASE("all pairs") {
  const auto open = [] { return gas().set_box(Box<double, 3>::open()); };
  check({.dt = 0.01}, open, steps(AllPairs{SoftenedGravity{1.0, 0.1}}, velocity_verlet));
}

TEST_CASE("neighbour lists come back as they were") {
  check({.dt = 0.005, .count = 120}, gas, steps(lennard_jones(), velocity_verlet));
  check({.dt = 0.005, .even = false}, gas, steps(lennard_jones() + LinearDrag{0.1}, velocity_verlet));
  check({.dt = 0.005}, gas, steps(lennard_jones(), trapezoidal));
  check(loosely({.dt = 0.005, .even = false}), gas,
        steps(lennard_jones(), backward_euler, newton({.rtol = 1e-4, .atol = 1e-6})));
}

#endif
