// Walls: throws, slopes and rolls on a plane, and the shape of a box.
#include <phistep/io/checkpoint.hpp>
#include <phistep/particles/bodies/particle_sums.hpp>
#include <phistep/particles/bodies/particles.hpp>
#include <phistep/particles/contacts/contact.hpp>
#include <phistep/particles/walls/walls.hpp>
#include <phistep/phistep.hpp>

#include <Eigen/Geometry>

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

using namespace walls_cases;

#if PHISTEP_QUICK

TEST_CASE("a ball thrown sliding ends rolling at 5/7 of its speed") {
  const double g = 10, k = 1e5, dt = 1e-4;
  auto y = resting<Grains>(g, k);
  y.v(0, 0) = 1;
  const double h = y.r(2, 0), inertia = 0.4 * 0.25;
  const Hooke law{.stiffness = k, .restitution = 0.3, .friction = 0.3};
  PhiStepper stepper{y, Gravity{Eigen::Vector3d(0, 0, -g)} + Walls{law, ground}, symplectic_euler};
  // About the line of contact, the y-axis' direction.
  const auto about_line = [&] { return y.r(2, 0) * y.v(0, 0) - y.r(0, 0) * y.v(2, 0) + inertia * y.omega(1, 0); };
  const double before = about_line();
  double slid_until = 0;
  for (int n = 0; n < 4000; ++n) {
    REQUIRE(stepper.step(y, n * dt, dt));
    REQUIRE(std::abs(about_line() - before) < 1e-10 * before);
    if (slid_until == 0 && y.v(0, 0) - h * y.omega(1, 0) < 0.5) slid_until = (n + 1) * dt;
  }
  // From the angular momentum: the spring's arm is h = R − δ, δ/R = 2e-4.
  CHECK(y.v(0, 0) == Approx(1 / (1 + inertia / (h * h))).epsilon(1e-9));
  CHECK(y.v(0, 0) == Approx(5. / 7).epsilon(2e-4));
  CHECK(y.omega(1, 0) * h == Approx(y.v(0, 0)).epsilon(1e-9));
  // Coulomb's force takes (7/2) μg from the speed of slipping; half of it was gone by then, seen at the end of a step.
  CHECK(slid_until == Approx(0.5 / (3.5 * 0.3 * g)).margin(1.5 * dt));
}

TEST_CASE("a block holds below the angle of friction and slides above") {
  const double g = 10, k = 1e5, dt = 1e-4, mu = 0.5;
  const auto slide = [&](double slope, int steps) {
    const double angle = std::atan(slope);
    auto y = resting<Blocks3>(g * std::cos(angle), k);
    const Hooke law{.stiffness = k, .restitution = 0.3, .friction = mu};
    PhiStepper stepper{y, Gravity{Eigen::Vector3d(g * std::sin(angle), 0, -g * std::cos(angle))} + Walls{law, ground},
                       symplectic_euler};
    for (int n = 0; n < steps; ++n) REQUIRE(stepper.step(y, n * dt, dt));
    return std::pair{y.r(0, 0), y.v(0, 0)};
  };
  // It comes to rest where its spring holds it; loaded at once the spring swings as far again, so at 0.45 < μ it may slip
  // a little first: half of that keeps the peak below.
  const auto held = slide(0.45, 5000);
  const double angle = std::atan(0.45);
  CHECK(std::abs(held.second) < 1e-8);
  CHECK(held.first < 3 * g * std::sin(angle) / (2. / 7 * k));
  CHECK(held.first > 0);
  const auto gentle = slide(0.2, 5000);
  CHECK(gentle.first == Approx(g * std::sin(std::atan(0.2)) / (2. / 7 * k)).epsilon(1e-6));
  // Above: a = g (sin − μ cos), the normal force being constant to rounding.
  const auto a = slide(0.55, 2000), b = slide(0.55, 5000);
  const double steep = std::atan(0.55), expected = g * (std::sin(steep) - mu * std::cos(steep));
  CHECK((b.second - a.second) / 0.3 == Approx(expected).epsilon(1e-8));
}

TEST_CASE("rolling resistance stops a rolling ball after the distance that it must") {
  // m a = f and I a/h = μ_r R F_n − f h: a = μ_r R g / (I/(m h) + h). The springs' lengths, μ_r g/k_r = 2e-5, and Δt v =
  // 1e-4 are what the distance of 1.4 is uncertain by.
  const double g = 10, k = 1e5, dt = 1e-4, mu_r = 0.05;
  auto y = resting<Grains>(g, k);
  const double h = y.r(2, 0);
  y.v(0, 0) = 1;
  y.omega(1, 0) = 1 / h;
  const Hooke law{.stiffness = k, .restitution = 0.3, .friction = 0.9, .rolling_friction = mu_r};
  PhiStepper stepper{y, Gravity{Eigen::Vector3d(0, 0, -g)} + Walls{law, ground}, symplectic_euler};
  for (int n = 0; n < 40000; ++n) REQUIRE(stepper.step(y, n * dt, dt));
  const double a = mu_r * 0.5 * g / (0.1 / h + h);
  CHECK(y.r(0, 0) == Approx(1 / (2 * a)).epsilon(3e-4));
  CHECK(std::abs(y.v(0, 0)) < 1e-8);
  CHECK(std::abs(y.omega(1, 0)) < 1e-8);
}

TEST_CASE("a belt carries what lies on it") {
  Plane<3> belt = ground;
  belt.velocity = Eigen::Vector3d(2, 0, 0);
  auto y = resting<Blocks3>(10, 1e5);
  PhiStepper stepper{
      y,
      Gravity{Eigen::Vector3d(0, 0, -10)} + Walls{Hooke{.stiffness = 1e5, .restitution = 0.3, .friction = 0.5}, belt},
      symplectic_euler};
  for (int n = 0; n < 10000; ++n) REQUIRE(stepper.step(y, n * 1e-4, 1e-4));
  CHECK(y.v(0, 0) == Approx(2).epsilon(1e-6));
}

TEST_CASE("a body that touches two walls has a spring at each: two grounds bear twice the mass to the bit") {
  // Without dashpots the forces don't depend on the mass, and twice a number is exact.
  const Hooke law{.stiffness = 1e4, .friction = 1e9, .tangential_damping = 0};
  const auto run = [&](double m, auto walls) {
    auto y = resting<Blocks3>(10, 1e4);
    y.set_mass(m);
    y.v(0, 0) = 0.01;
    PhiStepper stepper{y, Gravity{Eigen::Vector3d(0, 0, -10)} + walls, symplectic_euler};
    double farthest = 0;
    for (int n = 0; n < 300; ++n) {
      REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
      farthest = std::max(farthest, y.r(0, 0));
    }
    // v/ω with ω² = k_t/m, k_t = 2/7 k, and ωΔt = 0.05.
    CHECK(farthest == Approx(0.01 / std::sqrt(2. / 7 * 1e4)).epsilon(0.01));
    return y;
  };
  const auto one = run(1, Walls{law, ground}), two = run(2, Walls{law, ground, ground});
  CHECK(one.r == two.r);
  CHECK(one.v == two.v);
}

TEST_CASE("a solid box pushes out of its faces, edges and corners") {
  check_box([](const SolidBox<3>& box, const Eigen::Vector3d& r) {
    return pushed_by(Gravity{Eigen::Vector3d(0, 0, 0)} + Walls{Hooke{.stiffness = 1}, box}, r);
  });
}

TEST_CASE("walls remember across checkpoints and when bodies go") {
  const double g = 10, slope = std::atan(0.4);
  const Hooke law{.stiffness = 1e4, .restitution = 0.5, .friction = 0.5};
  const auto force = [&] {
    return Gravity{Eigen::Vector3d(g * std::sin(slope), 0, -g * std::cos(slope))} + Walls{law, ground};
  };
  const auto start = [&](int count) {
    Matrix r(3, count);
    for (int i = 0; i < count; ++i) r.col(i) << 0, 2 * i, 0.5 - g * std::cos(slope) / 1e4;
    Grains y{r};
    y.set_mass(1.0).set_radius(0.5);
    return y;
  };
  const double dt = 1e-3;
  const auto steps = [&](auto& stepper, auto& y, int from, int to) {
    for (int n = from; n < to; ++n) REQUIRE(stepper.step(y, n * dt, dt));
  };
  auto one = start(1);
  PhiStepper alone{one, force(), symplectic_euler};
  steps(alone, one, 0, 100);

  auto y = start(3);
  PhiStepper stepper{y, force(), symplectic_euler};
  steps(stepper, y, 0, 30);
  y.erase(1);
  y.erase(1);
  std::stringstream file;
  steps(stepper, y, 30, 60);
  save_checkpoint(file, y, stepper);
  auto z = start(1);
  PhiStepper again{z, force(), symplectic_euler};
  load_checkpoint(file, z, again);
  steps(again, z, 60, 100);
  CHECK((one.r == z.r && one.v == z.v && one.omega == z.omega));
  CHECK(one.omega.norm() > 0.1);
}

TEST_CASE("walls of fewer materials than a checkpoint's particles have are refused") {
  const auto start = [] {
    auto y = resting<Blocks3>(10, 1e4);
    y.set_type(Eigen::VectorXi::Constant(1, 2));
    return y;
  };
  const Gravity down{Eigen::Vector3d(0, 0, -10)};
  const Hooke law{.stiffness = 1e4};
  auto y = start(), z = start();
  PhiStepper three{y, down + Walls{Materials<Hooke>{3, law}, ground}, symplectic_euler};
  PhiStepper two{z, down + Walls{Materials<Hooke>{2, law}, ground}, symplectic_euler};
  REQUIRE(three.step(y, 0, 1e-3));
  std::stringstream file;
  save_checkpoint(file, y, three);
  load_checkpoint(file, z, two);
  CHECK_THROWS_WITH(two.step(z, 1e-3, 1e-3), contains("particle 0 is of type 2"));
}

TEST_CASE("what a pile weighs is the force on its ground") {
  const double g = 10, k = 1e4;
  Matrix r(3, 2);
  r << 0, 0, 0, 0, 0.5, 1.5;
  Blocks3 y{r};
  y.set_mass(1.0).set_radius(0.5);
  const Hooke law{.stiffness = k, .restitution = 0.5};
  const Plane<3> beside{.point = {-5, 0, 0}, .normal = {1, 0, 0}};
  PhiStepper stepper{y, Gravity{Eigen::Vector3d(0, 0, -g)} + Contact{law} + Walls{law, beside, ground}, backward_euler};
  for (int n = 0; n < 60; ++n) REQUIRE(stepper.step(y, 0.1 * n, 0.1));
  CHECK((force_on_wall(stepper, y, 1) - Eigen::Vector3d(0, 0, -2 * g)).norm() < 1e-8);
  CHECK(force_on_wall(stepper, y, 0).norm() == 0);
}

TEST_CASE("walls that can't be are refused") {
  const Hooke law{.stiffness = 1};
  CHECK_THROWS_WITH(Walls(law, Plane<3>{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}), contains("wall 0"));
  CHECK_THROWS_WITH(Walls(law, ground, SolidBox<3>{Eigen::Vector3d::Zero(), Eigen::Vector3d(1, 0, 1)}),
                    contains("wall 1"));
  Plane<3> typed = ground;
  typed.type = 2;
  CHECK_THROWS_WITH(Walls(Materials<Hooke>{2, law}, typed), contains("wall 0"));
  Blocks3 y{Matrix(Eigen::Vector3d(0, 0, 1))};
  PhiStepper stepper{y, Gravity{Eigen::Vector3d(0, 0, 0)} + Walls{law, ground}, symplectic_euler};
  CHECK_THROWS_WITH(stepper.step(y, 0, 1), contains("radii"));
}

TEST_CASE("walls: the corners of a box may be expressions of Eigen") {
  const auto box = inside_box(Eigen::Vector3d::Zero(), 2 * Eigen::Vector3d::Ones());
  REQUIRE(box.size() == 6);
  CHECK(std::get<Plane<3>>(box[4]).point == Eigen::Vector3d::Zero());
  CHECK(std::get<Plane<3>>(box[5]).point == Eigen::Vector3d::Constant(2));
  CHECK(std::get<Plane<3>>(box[5]).normal == -Eigen::Vector3d::UnitZ());
}

TEST_CASE("along a period a solid box stands at each of its images") {
  for (const double start : {0.1, -0.9, 1.1, 7.1}) {
    Particles<double, 3> y{Eigen::Vector3d{start, 0, 0}, Eigen::Vector3d{1, 0, 0}};
    Box<double, 3> box;
    box.is_periodic[0] = true, box.upper[0] = 1;
    y.set_radius(0.02).set_mass(1e-3).set_box(box);
    const SolidBox<3> block{.center = {0.75, 0, 0}, .half = {0.05, 0.5, 0.5}};
    PhiStepper stepper{y, Walls{Hooke{.stiffness = 1e4}, block}, symplectic_euler};
    REQUIRE(integrate(stepper, y, {0.0, 1.0}, fixed(1e-5)));
    CHECK(y.v(0, 0) == Approx(-1).epsilon(1e-3));
    CHECK(y.r(0, 0) - start == Approx(0.16).margin(0.01));
  }
}

#elif PHISTEP_FULL

TEST_CASE("a bounce returns the given part of the speed") {
  const auto bounce = [](const auto& law, double dt) {
    auto y = resting<Blocks3>(0, 1);
    y.r(2, 0) -= 1e-12;
    y.v(2, 0) = -1;
    PhiStepper stepper{y, Walls{law, ground}, velocity_verlet};
    for (int n = 0; n < 3000; ++n) REQUIRE(stepper.step(y, n * dt, dt));
    REQUIRE(y.r(2, 0) > 0.5);
    return y.v(2, 0);
  };
  // Of π√(m/k) = 9.9e-3 a step is 1e-3: Verlet's error is of the order of its square. Hertz' dashpot begins with δ^(1/4),
  // which makes it Δt^(5/4): 4e-4 at Δt/t_c = 1/520.
  CHECK(bounce(Hooke{.stiffness = 1e5, .restitution = 0.8}, 1e-5) == Approx(0.8).epsilon(1e-5));
  CHECK(bounce(Hertz{.modulus = 1e7, .restitution = 0.8}, 1e-5) == Approx(0.8).epsilon(4e-4));
}

TEST_CASE("a solid box pushes out of its faces, edges and corners") {
  check_box([](const SolidBox<3>& box, const Eigen::Vector3d& r) {
    return pushed_by(Walls{Hooke{.stiffness = 1}, box}, r);
  });
}

TEST_CASE("walls in the plane, and of float") {
  Particles<float, 2, Spin> y{Eigen::Matrix2Xf(Eigen::Vector2f(0, 0.4999f))};
  y.set_mass(1.0f).set_radius(0.5f).set_inertia_factor(0.5f);
  y.v(0, 0) = 1;
  Walls<Hooke, 2, float> walls{Hooke{.stiffness = 1e5, .restitution = 0.3, .friction = 0.3},
                               inside_box<Eigen::Vector2d>({-9, 0}, {9, 9})};
  PhiStepper stepper{y, Gravity{Eigen::Vector2f(0, -10)} + walls, symplectic_euler};
  for (int n = 0; n < 4000; ++n) REQUIRE(stepper.step(y, static_cast<float>(n) * 1e-4f, 1e-4f));
  CHECK(y.v(0, 0) == Approx(2. / 3).epsilon(1e-3));  // a disc: 1/(1 + ½)
}

TEST_CASE("a pile on the ground settles by implicit steps of many times an impact") {
  Matrix r(3, 3);
  r << 0, 0, 0, 0, 0, 0, 0.5, 1.5, 2.5;
  Blocks3 y{r};
  y.set_mass(1.0).set_radius(0.5);
  const double g = 10, k = 1e4, slope = 0.3;
  const Hooke law{.stiffness = k, .restitution = 0.5, .friction = 0.9};
  const Walls walls{law, ground};
  PhiStepper stepper{y, Gravity{Eigen::Vector3d(0, 0, -g)} + Contact{law} + walls, backward_euler};
  for (int n = 0; n < 60; ++n) REQUIRE(stepper.step(y, 0.1 * n, 0.1));  // an impact lasts 0.03
  CHECK(0.5 - y.r(2, 0) == Approx(3 * g / k).epsilon(1e-9));
  CHECK(1 - (y.r(2, 1) - y.r(2, 0)) == Approx(2 * g / k).epsilon(1e-9));
  CHECK(y.v.norm() < 1e-9);
  // One block on a slope below the angle of friction: its tangential spring holds it.
  auto block = resting<Blocks3>(g * std::cos(slope), k);
  PhiStepper held{block, Gravity{Eigen::Vector3d(g * std::sin(slope), 0, -g * std::cos(slope))} + walls,
                  backward_euler};
  for (int n = 0; n < 60; ++n) REQUIRE(held.step(block, 0.1 * n, 0.1));
  CHECK(block.r(0, 0) == Approx(g * std::sin(slope) / (2. / 7 * k)).epsilon(1e-9));
}

TEST_CASE("walls that can't be are refused") {
  Blocks3 y{Matrix(Eigen::Vector3d(0, 0, 1))};
  PhiStepper stepper{y, Walls{Hooke{.stiffness = 1}, ground}, symplectic_euler};
  CHECK_THROWS_WITH(stepper.step(y, 0, 1), contains("radii"));
}

#endif
