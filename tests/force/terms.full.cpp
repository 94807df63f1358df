// terms: the full product and what is dear to compile. The quick half is terms.test.cpp.
#include "force/terms_cases.hpp"

using namespace terms_cases;

TEMPLATE_TEST_CASE("a term adds to the force and does not overwrite it", "", Fixed, Dynamic, Columns, RowMajor) {
  check_terms<TestType>();
}

TEST_CASE("every term's Jacobian equals differences") {
  const auto y = grains<Dynamic>();
  const auto check = [&](auto force) { check_right(check_jacobian(force, y)); };
  check(Gravity{Eigen::Vector3d(1, 2, -9.81)});
  check(UniformForce{Eigen::Vector3d(1, 2, 3)});
  check(LinearDrag{0.7});
  check(spring_network<3>(one_spring));
  check(spring_network<3>(one_spring, SpringDamping{2.0}));
  check(spring_network<3>({{0, 1, 80.0, 5.0}}, SpringDamping{2.0}));  // compressed
  check(spring_network<2>({{0, 1, 3.0, 0.1}, {1, 2, 4.0, 0.9}, {2, 0, 5.0, 0.3}}, SpringDamping{0.4}));
  check(spring_network<1>({{0, 1, 3.0, 0.1}, {4, 2, 4.0, 0.9}}, SpringDamping{0.4}));
  check(LinearDrag{0.3} + spring_network<3>(one_spring, SpringDamping{2.0}) + Gravity{Eigen::Vector3d(0, 0, -1)});
}

TEST_CASE("gravity is an acceleration, a uniform force is a force") {
  const auto y = grains<Dynamic>();
  auto gravity = Gravity{Eigen::Vector3d(0, 0, -9.81)};
  Eigen::VectorXd m(6);
  m << 2, 2, 2, 5, 5, 5;
  CHECK(added(gravity, y, DenseMass<double>{m.asDiagonal()})[5] == Approx(-5 * 9.81));
}

TEST_CASE("gravity falls alike for all masses") {
  const auto fall = [](const auto&... masses) {
    SecondOrder<Columns> c;
    PhiStepper stepper{c.state, Gravity{Eigen::Vector3d(0, 0, -9.81)}, velocity_verlet, masses...};
    for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(c.state, 0, 0.1));
    return numbers(c.state);
  };
  CHECK(distance(fall(mass(7.0)), fall()) <= 1e-13);
  CHECK(distance(fall(mass(Eigen::Vector2d(0.1, 50))), fall()) <= 1e-13);
}

TEST_CASE("an acceleration or a force of the wrong dimension throws") {
  SecondOrder<Dynamic> c;  // six components: 4 don't fit
  PhiStepper stepper{c.state, Gravity{Eigen::Vector4d::Ones()}, forward_euler};
  CHECK_THROWS_AS(stepper.step(c.state, 0, 0.1), std::invalid_argument);
}

TEST_CASE("a term by reference sees later changes") {
  double k = 1;
  auto pull = [&k](const Dynamic& r) -> Dynamic { return -k * r; };
  auto sum = term(std::ref(pull)) + LinearDrag{0.0};
  const auto y = grains<Dynamic>();
  CHECK((added(sum, y, UnitMass{}) == -y.r));
  k = 2;
  CHECK((added(sum, y, UnitMass{}) == -2 * y.r));
}

TEST_CASE("terms work in float, explicit and implicit") {
  Motion<Eigen::Vector3f> y{Eigen::Vector3f(1, 2, 3), Eigen::Vector3f(-1, 0, 1)};
  const auto force = LinearDrag{0.5} + Gravity{Eigen::Vector3d(0, 0, -1)} + UniformForce{Eigen::Vector3d(1, 0, 0)};
  PhiStepper verlet{y, force, velocity_verlet, mass(2.0)};
  PhiStepper implicit{y, force, trapezoidal, mass(2.0)};
  auto z = y;
  for (int n = 0; n < 20; ++n) {
    REQUIRE(verlet.step(y, 0, 0.01f));
    REQUIRE(implicit.step(z, 0, 0.01f));
  }
  CHECK((y.r - z.r).norm() < 1e-4f);
}
