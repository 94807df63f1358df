// particles: the full product and what is dear to compile. The quick half is particles.test.cpp.
#include "particles/particles_cases.hpp"

using namespace particles_cases;

TEST_CASE("particles step as a motion with their own masses") {
  Atoms atoms = three();
  const Eigen::Vector3d masses{1, 2, 8};
  atoms.set_mass(masses);
  Motion<Eigen::Matrix3Xd> motion{atoms.r, atoms.v};
  const auto check = [&](auto scheme) {
    PhiStepper particles{atoms, spring, scheme};
    PhiStepper plain{motion, spring, scheme, mass(masses)};
    for (int n = 0; n < 20; ++n) {
      REQUIRE(particles.step(atoms, 0.05 * n, 0.05));
      REQUIRE(plain.step(motion, 0.05 * n, 0.05));
    }
    CHECK((atoms.r == motion.r));
    CHECK((atoms.v == motion.v));
    CHECK(particles.statistics() == plain.statistics());
  };
  check(velocity_verlet);
  check(trapezoidal);
}

TEST_CASE("what is held still isn't moved, and a copy of the state keeps its properties") {
  Atoms atoms = three();
  atoms.v.setZero();
  atoms.set_still({0, 1, 0});
  const Atoms before = atoms;
  PhiStepper stepper{atoms, spring, velocity_verlet};
  for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(atoms, 0.1 * n, 0.1));
  CHECK((atoms.r.col(1) == before.r.col(1)));
  CHECK((atoms.v.col(1) == before.v.col(1)));
  CHECK((atoms.r.col(0) != before.r.col(0)));
  // Implicitly, something held is something heavier than rounding sees.
  atoms = before;
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
  Grains grains{Eigen::Matrix2Xd::Zero(2, 2)};
  CHECK_THROWS_AS((PhiStepper{grains, Brake{}, forward_euler}), std::invalid_argument);  // no radii, no inertia
  grains.set_mass(5.0).set_radius(Eigen::Vector2d{1, 2});
  grains.omega << 1, 1;
  PhiStepper spinning{grains, Brake{}, forward_euler};
  REQUIRE(spinning.step(grains, 0.0, 0.1));
  // I = ⅖ m R² = 2 and 8
  CHECK(std::abs(grains.omega(0) - 0.9) < 1e-15);
  CHECK(std::abs(grains.omega(1) - 0.975) < 1e-15);

  Spray spray{Eigen::Matrix3Xd::Zero(3, 1)};
  spray.temperature << 100;
  spray.set_heat_capacity(6.0);
  PhiStepper cooling{spray, Brake{}, forward_euler};
  REQUIRE(cooling.step(spray, 0.0, 0.1));
  CHECK(std::abs(spray.temperature(0) - 96) < 1e-13);
}

TEST_CASE("properties that can't be name their particle, and change nothing") {
  Atoms atoms = three();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto message = [&](auto&& f) -> std::string {
    try {
      f();
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "";
  };
  CHECK(message([&] { atoms.set_mass(Eigen::Vector3d{1, 0, 1}); }).find("mass of particle 1") != std::string::npos);
  CHECK(message([&] {
          atoms.set_radius(Eigen::Vector3d{1, 1, nan});
        }).find("radius of particle 2") != std::string::npos);
  CHECK(message([&] { atoms.set_type(Eigen::Vector3i{0, 0, -1}); }).find("type of particle 2") != std::string::npos);
  CHECK(message([&] { atoms.set_mass(Eigen::Vector2d{1, 1}); }).find("2 values for 3") != std::string::npos);
  CHECK(message([&] {
          atoms.set_box(Box<double, 3>::periodic({0, 0, 0}, {1, 0, 1}));
        }).find("axis 1") != std::string::npos);
  CHECK(message([&] { atoms.add(Atoms{Eigen::Matrix3Xd::Zero(3, 1)}.set_radius(1.0)); }).find("radius") !=
        std::string::npos);
  CHECK(message([&] { atoms.r.conservativeResize(3, 4), PhiStepper{atoms, spring, trapezoidal}; }) != "");
  CHECK((atoms.mass() == Eigen::Vector3d::Ones()));
  CHECK(atoms.radius().size() == 0);
}
