// Programs about particles as a user writes them.
#include <phistep/io.hpp>
#include <phistep/particles.hpp>

#include <sstream>

#include "support/catch.hpp"

#if PHISTEP_QUICK

TEST_CASE("stars") {
  phistep::Particles<float, 2> stars{Eigen::Matrix2Xf::Random(2, 5)};
  phistep::PhiStepper stepper{stars, phistep::AllPairs{phistep::SoftenedGravity{1, 0.1}}, phistep::velocity_verlet};
  REQUIRE(stepper.step(stars, 0.0f, 0.01f));
  CHECK(phistep::momentum(stars).norm() < 1e-6f);
}

#elif PHISTEP_FULL

TEST_CASE("a law of one's own beside a built-in one") {
  const Eigen::Matrix3Xd positions = 1.5 * Eigen::Matrix3Xd::Random(3, 8) + Eigen::Matrix3Xd::Constant(3, 8, 5);
  const Eigen::Vector3d lower = Eigen::Vector3d::Zero(), upper = Eigen::Vector3d::Constant(10);

  phistep::Particles<double, 3> atoms{positions};
  atoms.set_mass(39.95).set_box(phistep::Box<double, 3>::periodic(lower, upper));

  auto repulsion = [](auto r2) { return 1.0 / (r2 * r2); };
  auto force = phistep::Pairs{phistep::LennardJones{.epsilon = 1, .sigma = 1}, 2.5} + phistep::Pairs{repulsion, 1.2};
  phistep::PhiStepper stepper{atoms, force, phistep::velocity_verlet};

  std::ostringstream frames;
  const auto report = phistep::integrate(stepper, atoms, {0.0, 1e-3}, phistep::fixed(1e-4),
                                         phistep::every(5e-4, phistep::extended_xyz(frames)));
  REQUIRE(report);
  CHECK(report.statistics.force_calls == 11);
  CHECK(frames.str().find("Lattice") != std::string::npos);
}

TEST_CASE("grains with friction, between walls, asleep when they rest") {
  phistep::Particles<double, 3, phistep::Spin> grains{Eigen::Vector3d{0, 0, 0.5}};
  grains.set_mass(1.0).set_radius(0.5);
  const phistep::Hertz steel = phistep::Hertz::elastic(1e7, 0.3);
  auto force = phistep::Gravity{Eigen::Vector3d{0, 0, -9.81}} + phistep::QuadraticDrag{0.1} + phistep::Contact{steel} +
               phistep::Walls<phistep::Hertz>{steel, phistep::Plane<3>{{0, 0, 0}, {0, 0, 1}}} +
               phistep::ExternalField{[](const Eigen::Vector3d& r) -> Eigen::Vector3d { return -0.1 * r; }};
  phistep::Sleeping stepper{phistep::PhiStepper{grains, force, phistep::symplectic_euler},
                            phistep::SleepOptions{.speed = 1e-3}};
  REQUIRE(phistep::integrate(stepper, grains, {0.0, 0.01}, phistep::fixed(1e-4)));
  CHECK(grains.r(2, 0) < 0.5);
}

#endif
