// What particles.test.cpp and particles.full.cpp share.
#pragma once

#include <phistep/particles/bodies/particles.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Atoms = Particles<double, 3>;
using Grains = Particles<double, 2, Spin>;
using Spray = Particles<double, 3, Temperature>;

static_assert(State<Atoms> && State<Grains> && State<Spray> && State<Particles<float, 3, Spin, Temperature>>);
static_assert(solved_blocks<Atoms> == 1 && solved_blocks<Grains> == 2);
static_assert(solved_blocks<Particles<float, 3, Spin, Temperature>> == 3);

namespace particles_cases {
inline Atoms three() {
  Atoms atoms{Eigen::Matrix3Xd::Random(3, 3)};
  atoms.v.setRandom();
  return atoms;
}
inline const auto spring = [](const Eigen::Matrix3Xd& r) -> Eigen::Matrix3Xd { return -4.0 * r; };
struct Brake : ForceTerm {
  static constexpr bool uses_velocity = true, uses_time = false;
  void add(auto, const auto& y, auto& out) const {
    if constexpr (requires { y.omega; }) out.torque -= 2.0 * y.omega;
    if constexpr (requires { y.temperature; }) out.heat.array() -= 3.0 * (y.temperature.array() - 20.0);
  }
};

void check_as_motion(auto scheme) {
  Atoms atoms = three();
  const Eigen::Vector3d masses{1, 2, 8};
  atoms.set_mass(masses);
  Motion<Eigen::Matrix3Xd> motion{atoms.r, atoms.v};
  PhiStepper particles{atoms, spring, scheme};
  PhiStepper plain{motion, spring, scheme, mass(masses)};
  for (int n = 0; n < 20; ++n) {
    REQUIRE(particles.step(atoms, 0.05 * n, 0.05));
    REQUIRE(plain.step(motion, 0.05 * n, 0.05));
  }
  CHECK((atoms.r == motion.r));
  CHECK((atoms.v == motion.v));
  CHECK(particles.statistics() == plain.statistics());
}

/// What f says that is wrong.
std::string message(auto&& f) {
  try {
    f();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

}  // namespace particles_cases
