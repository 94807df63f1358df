// What extended_xyz_reader.test.cpp and extended_xyz_reader.full.cpp share.
#pragma once

#include <phistep/io/extended_xyz.hpp>
#include <phistep/io/extended_xyz_reader.hpp>

#include <Eigen/Core>

#include <cmath>
#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace extended_xyz_reader_cases {
template <class P>
P read(const std::string& text) {
  std::istringstream in(text);
  P particles;
  ExtendedXyzReader frames{in, {}, "grains.xyz"};
  REQUIRE(frames.next(particles));
  return particles;
}
using Atoms = Particles<double, 3>;
template <class Scalar>
using Grains = Particles<Scalar, 3, Spin, Temperature>;

/// Everything that particles can have, in numbers without an end.
template <class Scalar>
Grains<Scalar> grains() {
  using Vectors = Eigen::Matrix<Scalar, 3, Eigen::Dynamic>;
  const auto some = [](double phase) {
    return Vectors(Vectors::NullaryExpr(3, 5, [phase](Eigen::Index i, Eigen::Index j) {
      return static_cast<Scalar>(std::sin(phase + static_cast<double>(3 * i + j)) / 3);
    }));
  };
  Grains<Scalar> y{some(0), some(1)};
  y.omega = some(2);
  y.temperature = some(3).row(0);
  const auto positive = [&](double phase) {
    return (some(phase).row(1).array().square() + Scalar(1) / 7).matrix().transpose().eval();
  };
  y.set_mass(positive(4)).set_radius(positive(5)).set_heat_capacity(positive(6)).set_charge(some(7).row(0).transpose());
  Eigen::VectorXi type(5);
  type << 2, 0, 2, 0, 2;
  y.set_type(type).set_still({0, 1, 0, 0, 1}).set_inertia_factor(Scalar(1) / 3).set_id({8, 3, 5, 1, 2});
  Box<Scalar, 3> box;
  box.lower << Scalar(-0.1), Scalar(-1) / 3, 0;
  box.upper << Scalar(1) / 7, Scalar(2) / 3, 1;
  box.is_periodic = {true, true, false};
  y.set_box(box);
  return y;
}
inline void check_equal(const auto& a, const auto& b) {
  CHECK((a.r == b.r));
  CHECK((a.v == b.v));
  CHECK((a.mass() == b.mass()));
  CHECK((a.radius() == b.radius()));
  CHECK((a.type() == b.type()));
  CHECK((a.charge() == b.charge()));
  CHECK((a.body().heat_capacity == b.body().heat_capacity));
  CHECK(a.body().still == b.body().still);
  CHECK(a.body().inertia_factor == b.body().inertia_factor);
  CHECK(a.id() == b.id());
  CHECK(a.box() == b.box());
}

template <class Scalar>
void check_round_trip() {
  const auto y = grains<Scalar>();
  std::stringstream file;
  write_extended_xyz(file, 0.1, y, {.species = {"X"}, .exact = true});
  Grains<Scalar> back;
  double time = 0;
  REQUIRE(read_extended_xyz(file, back, &time));
  check_equal(y, back);
  CHECK((y.omega == back.omega));
  CHECK((y.temperature == back.temperature));
  CHECK(time == 0.1);
  CHECK_FALSE(read_extended_xyz(file, back));
}

}  // namespace extended_xyz_reader_cases
