// particles: the full product and what is dear to compile. The quick half is particles.test.cpp.
#include "particles/bodies/particles_cases.hpp"

using namespace particles_cases;

TEST_CASE("particles step as a motion with their own masses") {
  check_as_motion(velocity_verlet);
  check_as_motion(trapezoidal);
}

TEST_CASE("what is held still isn't moved, and a copy of the state keeps its properties") {
  Atoms atoms = three();
  atoms.v.setZero();
  atoms.set_still({0, 1, 0});
  const Atoms before = atoms;
  // Implicitly, something held is something heavier than rounding sees.
  PhiStepper implicit{atoms, spring, backward_euler};
  for (int n = 0; n < 10; ++n) REQUIRE(implicit.step(atoms, 0.1 * n, 0.1));
  CHECK((atoms.r.col(1) == before.r.col(1)));
  CHECK(atoms.v.col(1).norm() < 1e-30);
}

TEST_CASE("weight and uniform fields see the masses") {
  Atoms atoms = three();
  atoms.set_mass(Eigen::Vector3d{1, 2, 3});
  const Eigen::Matrix3Xd v0 = atoms.v;
  PhiStepper stepper{atoms, Gravity{Eigen::Vector3d{0, 0, -10}} + LinearDrag{0.0}, forward_euler};
  REQUIRE(stepper.step(atoms, 0.0, 0.5));
  for (int i = 0; i < 3; ++i) CHECK((atoms.v.col(i) - v0.col(i) - Eigen::Vector3d{0, 0, -5}).norm() < 1e-15);
}

TEST_CASE("spin and temperature are blocks of their own") {
  Spray spray{Eigen::Matrix3Xd::Zero(3, 1)};
  spray.temperature << 100;
  spray.set_heat_capacity(6.0);
  PhiStepper cooling{spray, Brake{}, forward_euler};
  REQUIRE(cooling.step(spray, 0.0, 0.1));
  CHECK(std::abs(spray.temperature(0) - 96) < 1e-13);
}

TEST_CASE("properties that can't be name their particle, and change nothing") {
  Atoms atoms = three();
  CHECK(message([&] { atoms.r.conservativeResize(3, 4), PhiStepper{atoms, spring, trapezoidal}; }) != "");
  CHECK((atoms.mass() == Eigen::Vector3d::Ones()));
  CHECK(atoms.radius().size() == 0);
}
