#include <phistep/particles.hpp>

#include <cmath>

#include "support/catch.hpp"

using namespace phistep;
using Eigen::Vector3d;

TEST_CASE("sums over particles, with spin and without") {
  Particles<double, 3, Spin> y{(Eigen::Matrix3Xd(3, 2) << 1, 0, 0, 2, 0, 0).finished()};
  y.set_mass(Eigen::Vector2d{2, 3}).set_radius(0.5);
  y.v.col(0) = Vector3d{0, 1, 0};
  y.v.col(1) = Vector3d{-1, 0, 0};
  y.omega.col(1) = Vector3d{0, 0, 10};  // I = ⅖ · 3 · ¼ = 0.3
  CHECK(std::abs(kinetic_energy(y) - (0.5 * 2 + 0.5 * 3 + 0.5 * 0.3 * 100)) < 1e-14);
  CHECK((momentum(y) - Vector3d{-3, 2, 0}).norm() < 1e-15);
  CHECK((center_of_mass(y) - Vector3d{0.4, 1.2, 0}).norm() < 1e-15);
  CHECK((angular_momentum(y) - Vector3d{0, 0, 2 + 6 + 3}).norm() < 1e-14);
  CHECK((angular_momentum(y, Vector3d{1, 2, 0}) - Vector3d{0, 0, 3}).norm() < 1e-14);
  CHECK(std::abs(temperature(y) - 5.0 / 3) < 1e-15);
  Particles<double, 2> flat{(Eigen::Matrix2Xd(2, 1) << 3, 0).finished(), (Eigen::Matrix2Xd(2, 1) << 0, 2).finished()};
  CHECK(angular_momentum(flat)[0] == 6);
  CHECK(temperature(flat) == 0);
}

TEST_CASE("the pressure of a pair of particles is that of its virial") {
  // One spring-like pair at distance 1 in a box of 10: F/r = 5, Σ r·f = 5.
  Particles<double, 3> y{(Eigen::Matrix3Xd(3, 2) << 0, 1, 0, 0, 0, 0).finished()};
  y.set_box(Box<double, 3>::periodic(Vector3d::Zero(), Vector3d::Constant(10)));
  y.v.col(0) = Vector3d{2, 0, 0};
  const auto law = [](auto r2) { return 5.0 + 0.0 * r2; };
  PhiStepper stepper{y, Pairs{law, 2.0} + LinearDrag{1.0}, velocity_verlet};
  CHECK(std::abs(pressure(stepper, y) - (4 + 5) / 3000.0) < 1e-16);
  y.set_box(Box<double, 3>::open());
  CHECK(std::isnan(pressure(stepper, y)));
}
