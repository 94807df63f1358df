// What walls.test.cpp and walls.full.cpp share.
#pragma once

#include <Eigen/Geometry>

#include <phistep/io/checkpoint.hpp>
#include <phistep/particles/bodies/particles.hpp>
#include <phistep/particles/contacts/contact.hpp>
#include <phistep/particles/walls/walls.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <functional>
#include <sstream>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace walls_cases {

using Grains = Particles<double, 3, Spin>;
using Blocks3 = Particles<double, 3>;  // can't turn: what slides like a block
using Matrix = Eigen::Matrix3Xd;

inline const Plane<3> ground{.point = Eigen::Vector3d::Zero(), .normal = Eigen::Vector3d(0, 0, 2)};

/// One body of mass 1 and radius ½ that its weight presses into a ground of stiffness k as deep as it must.
template <class State>
State resting(double weight, double k) {
  State y{Matrix(Eigen::Vector3d(0, 0, 0.5 - weight / k))};
  y.set_mass(1.0).set_radius(0.5);
  return y;
}

/// @param pushed  the velocity that a step of 1 gives a ball of mass 1 and radius ½ at rest at r
inline void check_box(const std::function<Eigen::Vector3d(const SolidBox<3>& box, const Eigen::Vector3d& r)>& pushed) {
  const double c = std::sqrt(0.5);
  SolidBox<3> box{.center = Eigen::Vector3d(1, 2, 3), .half = Eigen::Vector3d(1, 2, 3)};
  const auto push = [&](const Eigen::Vector3d& r) { return pushed(box, r); };
  CHECK((push({2.25, 3, 4}) - Eigen::Vector3d(0.25, 0, 0)).norm() < 1e-15);
  CHECK((push({1, 4.25, 4}) - Eigen::Vector3d(0, 0.25, 0)).norm() < 1e-15);
  CHECK((push({1, 2, -0.25}) - Eigen::Vector3d(0, 0, -0.25)).norm() < 1e-15);
  CHECK(push({2.5, 3, 4}).norm() == 0);
  const double d = 0.25;  // at an edge the distance is d√2, at a corner d√3
  CHECK((push({2 + d, 4 + d, 3}) - (0.5 - d / c) * Eigen::Vector3d(c, c, 0)).norm() < 1e-15);
  CHECK((push({-d, -d, -d}) - (0.5 / std::sqrt(3.0) - d) * Eigen::Vector3d(-1, -1, -1)).norm() < 1e-15);
  // Inside, out by the shortest way: 0.1 below a face.
  CHECK((push({1.9, 2, 3}) - Eigen::Vector3d(0.6, 0, 0)).norm() < 1e-15);
  box.axes = Eigen::AngleAxisd(M_PI / 4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  CHECK((push({1 + 1.25 * c, 2 + 1.25 * c, 3}) - 0.25 * Eigen::Vector3d(c, c, 0)).norm() < 1e-15);
}

/// One step of 1 by `force`.
Eigen::Vector3d pushed_by(const auto& force, const Eigen::Vector3d& r) {
  Blocks3 y{Matrix(r)};
  y.set_mass(1.0).set_radius(0.5);
  PhiStepper stepper{y, force, symplectic_euler};
  REQUIRE(stepper.step(y, 0, 1));
  return y.v.col(0);
}

}  // namespace walls_cases
