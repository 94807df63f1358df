// Contacts of bodies of other kinds, and in implicit steps. In short: contact.test.cpp.
#include "particles/contacts/contact_cases.hpp"

using namespace contact_cases;

TEST_CASE("contacts keep momentum and angular momentum") {
  check_momentum(rough);
  check_momentum(Hooke{.stiffness = 1e3, .restitution = 0.7, .friction = 0.4, .rolling_friction = 0.1});
  check_momentum(
      Hertz{.modulus = 1e4, .shear_modulus = 7e3, .restitution = 0.7, .friction = 0.4, .rolling_friction = 0.1});
}

TEST_CASE("in the plane bodies do what they do in space") {
  Grains y = jumble(11, 10, 1.2);
  y.r.row(2).setZero(), y.v.row(2).setZero(), y.omega.topRows(2).setZero();
  Particles<double, 2, Spin> z{y.r.topRows(2)};
  z.v = y.v.topRows(2), z.omega = y.omega.row(2);
  z.set_mass(y.mass()).set_radius(y.radius());
  PhiStepper space{y, Contact{rough}, symplectic_euler};
  PhiStepper plane{z, Contact{rough}, symplectic_euler};
  for (int n = 0; n < 200; ++n) {
    REQUIRE(space.step(y, n * 1e-3, 1e-3));
    REQUIRE(plane.step(z, n * 1e-3, 1e-3));
  }
  CHECK((y.r.topRows(2) == z.r && y.v.topRows(2) == z.v && y.omega.row(2) == z.omega));
}

TEST_CASE("bodies of float") {
  Grains y = jumble(15, 10, 1.2);
  Particles<float, 3, Spin> z{y.r.cast<float>()};
  z.v = y.v.cast<float>(), z.omega = y.omega.cast<float>();
  z.set_mass(y.mass().cast<float>().eval()).set_radius(y.radius().cast<float>().eval());
  PhiStepper a{y, Contact{rough}, symplectic_euler};
  PhiStepper b{z, Contact<Hooke, float>{rough}, symplectic_euler};
  for (int n = 0; n < 60; ++n) {
    REQUIRE(a.step(y, n * 1e-3, 1e-3));
    REQUIRE(b.step(z, static_cast<float>(n) * 1e-3f, 1e-3f));
  }
  CHECK((y.r - z.r.cast<double>()).norm() < 1e-4);
}

TEST_CASE("every pair of types has its law") {
  // Two soft ones, and a soft with a hard one, pushed together alike.
  const auto push = [](int a, int b) {
    Matrix r(3, 2);
    r << 0, 0.99, 0, 0, 0, 0;
    auto y = bodies(r);
    y.set_type(Eigen::Vector2i(a, b));
    Materials<Hooke> materials{2, Hooke{.stiffness = 100}};
    materials.set(0, 1, Hooke{.stiffness = 1000});
    PhiStepper stepper{y, Contact{materials}, symplectic_euler};
    REQUIRE(stepper.step(y, 0, 1));
    return y.v(0, 1);
  };
  CHECK(push(0, 0) == Approx(1));
  CHECK(push(1, 0) == Approx(10));
  CHECK(push(0, 1) == Approx(10));
  CHECK(push(1, 1) == Approx(1));
}

TEST_CASE("what can't work is said, with the body's number") {
  const Matrix r = three();
  Particles<double, 3> bare{r};
  CHECK_THROWS_WITH(one_step(bare, Contact{rough}), contains("radii"));
  auto typed = bodies(r);
  typed.set_type(Eigen::Vector3i(0, 1, 2));
  CHECK_THROWS_WITH(one_step(typed, Contact{Materials<Hooke>{2, rough}}), contains("particle 2"));
  Matrix same = Matrix::Zero(3, 2);
  auto one_place = bodies(same);
  CHECK(one_step(one_place, Contact{rough}).outcome() == Outcome::non_finite_force);  // no direction is theirs
  CHECK(one_place.v.norm() == 0);
}

TEST_CASE("a pile settles by implicit steps of many times an impact") {
  // Backward Euler at φ = 1 on a column of three bodies that weigh on each other and on one that is held.
  Matrix r(3, 4);
  r << 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3;
  auto y = bodies<Smooth>(r);
  y.set_still({1, 0, 0, 0});
  const double g = 10, k = 1e4;
  PhiStepper stepper{y, Gravity{Eigen::Vector3d(0, 0, -g)} + Contact{Hooke{.stiffness = k, .restitution = 0.5}},
                     backward_euler};
  const double dt = 0.1;  // of 0.022 that an impact lasts
  for (int n = 0; n < 60; ++n) REQUIRE(stepper.step(y, n * dt, dt));
  // Each spring carries what is above it.
  for (int i = 1; i < 4; ++i) CHECK(1 - (y.r(2, i) - y.r(2, i - 1)) == Approx((4 - i) * g / k).epsilon(1e-9));
  CHECK(y.v.norm() < 1e-9);
}
