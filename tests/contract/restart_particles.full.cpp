// Particles, restarted anywhere: all schemes and forces. The quick half: restart_particles.test.cpp.
#include <phistep/particles.hpp>

#include "contract/restart.hpp"
#include "contract/restart_particles_cases.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace restart_particles;

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
