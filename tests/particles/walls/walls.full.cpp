// walls: the full product and what is dear to compile. The quick half is walls.test.cpp.
#include "particles/walls/walls_cases.hpp"

using namespace walls_cases;

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
