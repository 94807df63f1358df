// What walls.test.cpp and walls.full.cpp share.
#pragma once

#include <Eigen/Geometry>

#include <phistep/contacts/contact.hpp>
#include <phistep/contacts/walls.hpp>
#include <phistep/io/checkpoint.hpp>
#include <phistep/particles/particles.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
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

}  // namespace walls_cases
