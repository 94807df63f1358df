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

using namespace particles_cases;

#if PHISTEP_QUICK

TEST_CASE("particles step as a motion with their own masses") { check_as_motion(velocity_verlet); }

TEST_CASE("a stepper sees that a property was set, and that particles came or went") {
  Atoms atoms = three();
  PhiStepper stepper{atoms, spring, velocity_verlet};
  REQUIRE(stepper.step(atoms, 0.0, 0.1));
  const auto fresh_agrees = [&] {
    Atoms copy = atoms;
    PhiStepper fresh{copy, spring, velocity_verlet};
    REQUIRE(fresh.step(copy, 0.1, 0.1));
    REQUIRE(stepper.step(atoms, 0.1, 0.1));
    CHECK((atoms.r == copy.r));
    CHECK((atoms.v == copy.v));
  };
  atoms.set_mass(5.0);
  fresh_agrees();
  Atoms more{Eigen::Matrix3Xd::Ones(3, 2)};
  atoms.add(more.set_mass(3.0));
  CHECK(atoms.size() == 5);
  fresh_agrees();
  atoms.erase(1);
  CHECK(atoms.size() == 4);
  CHECK(atoms.id() == std::vector<std::int64_t>{0, 2, 3, 4});
  fresh_agrees();
  atoms.add(more);
  CHECK(atoms.id().back() == 6);
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
}

TEST_CASE("who goes takes all that was its own along") {
  Grains grains{Eigen::Matrix2Xd::Zero(2, 4)};
  const Eigen::Vector4d number{1, 2, 3, 4};
  for (Eigen::Index i = 0; i < 4; ++i) grains.r.col(i).setConstant(number[i]), grains.v.col(i).setConstant(-number[i]);
  grains.omega = 10 * number.transpose();
  grains.set_mass(std::vector<float>{1, 2, 3, 4}).set_type(std::vector<int>{1, 2, 3, 4});
  CHECK((grains.mass().array() == Eigen::Array4d{1, 2, 3, 4}).all());
  CHECK((grains.type().array() == Eigen::Array4i{1, 2, 3, 4}).all());
  grains.set_mass(number).set_radius(number / 8).set_type(Eigen::Vector4i{1, 2, 3, 4}).set_charge(-number);
  grains.set_heat_capacity(2 * number).set_still({1, 0, 0, 1});
  grains.erase(0);
  const Eigen::Vector3d left{2, 3, 4};
  CHECK(grains.r.row(1) == left.transpose());
  CHECK(grains.v.row(0) == -left.transpose());
  CHECK(grains.omega == 10 * left.transpose());
  CHECK(grains.mass() == left);
  CHECK(grains.radius() == left / 8);
  CHECK(grains.type() == Eigen::Vector3i{2, 3, 4});
  CHECK(grains.charge() == -left);
  CHECK(grains.body().heat_capacity == 2 * left);
  CHECK(grains.body().still == std::vector<std::uint8_t>{0, 0, 1});
  CHECK(grains.id() == std::vector<std::int64_t>{1, 2, 3});
}

TEST_CASE("particles added to themselves are there twice") {
  Atoms atoms = three();
  const Eigen::Matrix3Xd r = atoms.r, v = atoms.v;
  atoms.add(atoms);
  REQUIRE(atoms.size() == 6);
  CHECK((atoms.r.leftCols(3) == r && atoms.r.rightCols(3) == r));
  CHECK((atoms.v.leftCols(3) == v && atoms.v.rightCols(3) == v));
  CHECK(atoms.id() == std::vector<std::int64_t>{0, 1, 2, 3, 4, 5});
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
}

TEST_CASE("properties that can't be name their particle, and change nothing") {
  Atoms atoms = three();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(message([&] { atoms.set_mass(Eigen::Vector3d{1, 0, 1}); }).find("mass of particle 1") != std::string::npos);
  CHECK(message([&] {
          atoms.set_radius(Eigen::Vector3d{1, 1, nan});
        }).find("radius of particle 2") != std::string::npos);
  for (const double bad : {0.0, -0.5, nan, HUGE_VAL, -HUGE_VAL}) {
    const Eigen::Vector3d second{1, bad, 1};
    CHECK_THAT(message([&] { Atoms{atoms}.set_mass(second); }), contains("mass of particle 1"));
    CHECK_THAT(message([&] { Atoms{atoms}.set_radius(second); }), contains("radius of particle 1"));
    CHECK_THAT(message([&] { Atoms{atoms}.set_heat_capacity(second); }), contains("heat capacity of particle 1"));
    CHECK((message([&] { Atoms{atoms}.set_charge(second); }) == "") == std::isfinite(bad));
  }
  CHECK(message([&] { atoms.set_type(Eigen::Vector3i{0, 0, -1}); }).find("type of particle 2") != std::string::npos);
  CHECK(message([&] { atoms.set_mass(Eigen::Vector2d{1, 1}); }).find("2 values for 3") != std::string::npos);
  CHECK_THAT(message([&] { atoms.set_mass(std::vector<double>{}); }), contains("0 values of mass for 3 particles"));
  CHECK(message([&] {
          atoms.set_box(Box<double, 3>::periodic({0, 0, 0}, {1, 0, 1}));
        }).find("axis 1") != std::string::npos);
  CHECK(message([&] { atoms.add(Atoms{Eigen::Matrix3Xd::Zero(3, 1)}.set_radius(1.0)); }).find("radius") !=
        std::string::npos);
  CHECK(message([&] { atoms.r.conservativeResize(3, 4), PhiStepper{atoms, spring, velocity_verlet}; }) != "");
  CHECK((atoms.mass() == Eigen::Vector3d::Ones()));
  CHECK(atoms.radius().size() == 0);
}

TEST_CASE("an empty scene and a single particle step") {
  Atoms none, one{Eigen::Matrix3Xd::Ones(3, 1)};
  PhiStepper empty{none, spring, velocity_verlet};
  REQUIRE(empty.step(none, 0.0, 0.1));
  PhiStepper single{one, spring, velocity_verlet};
  REQUIRE(single.step(one, 0.0, 0.1));
  none.add(one);
  REQUIRE(empty.step(none, 0.1, 0.1));
  CHECK(none.size() == 1);
}

TEST_CASE("a NaN in one particle is named by the user's index") {
  Atoms atoms = three();
  PhiStepper stepper{atoms, spring, velocity_verlet};
  atoms.r(1, 2) = std::numeric_limits<double>::quiet_NaN();
  const StepReport report = stepper.step(atoms, 0.0, 0.1);
  CHECK(report.outcome() == Outcome::non_finite_state);
  INFO(report.message());
  CHECK(report.message().find("2") != std::string::npos);
}

TEST_CASE("a checkpoint holds properties, and restores another number of particles") {
  Grains grains{Eigen::Matrix2Xd::Random(2, 4)};
  grains.set_mass(2.0)
      .set_radius(0.5)
      .set_type(Eigen::Vector4i{0, 1, 1, 0})
      .set_box(Box<double, 2>::periodic({-1, -1}, {1, 1}));
  grains.erase(2);
  Writer out;
  out(grains);
  Grains other{Eigen::Matrix2Xd::Zero(2, 1)};
  Reader in{out.bytes()};
  in(other);
  in.finish();
  CHECK((other.r == grains.r));
  CHECK(other.id() == grains.id());
  CHECK((other.type() == grains.type()));
  CHECK(other.box() == grains.box());
}

#elif PHISTEP_FULL

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

#endif
