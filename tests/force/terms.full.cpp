// terms: the full product and what is dear to compile. The quick half is terms.test.cpp.
#include "force/terms_cases.hpp"

using namespace terms_cases;

// The contract of every term, in every shape of a state.
TEMPLATE_TEST_CASE("a term adds to the force and does not overwrite it", "", Fixed, Dynamic, Columns, RowMajor) {
  const auto y = grains<TestType>();
  const auto check = [&](auto term) {
    check_added(numbers(typename TestType::PlainObject(added(term, y, UnitMass{}))),
                numbers(typename TestType::PlainObject(added(term, y, UnitMass{}, 10.0))),
                numbers(Dynamic(added(term, grains<Dynamic>(), UnitMass{}))));
  };
  check(Gravity{Eigen::Vector3d(1, 2, -9.81)});
  check(UniformForce{Eigen::Vector3d(1, 2, 3)});
  check(LinearDrag{0.7});
  if constexpr (!TestType::IsRowMajor) {  // which springs refuse, see tests/compile
    check(spring_network<3>(one_spring));
    check(spring_network<3>(one_spring, SpringDamping{2.0}));
    check(QuadraticDrag{0.7});
    check(ExternalField{[](const Eigen::Vector3d& r) -> Eigen::Vector3d { return r.squaredNorm() * r; }});
  }
  check(term([](const auto& r) { return typename std::remove_cvref_t<decltype(r)>::PlainObject(-r); }));
  check(LinearDrag{0.7} + Gravity{Eigen::Vector3d(0, 0, -1)} + UniformForce{Eigen::Vector3d(0, 1, 0)});
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
  auto uniform = UniformForce{Eigen::Vector3d(0, 0, -9.81)};
  Eigen::VectorXd m(6);
  m << 2, 2, 2, 5, 5, 5;
  const DiagonalMass<double> masses{m};
  CHECK(added(gravity, y, masses)[5] == Approx(-5 * 9.81));
  CHECK(added(gravity, y, ScalarMass<double>{3})[2] == Approx(-3 * 9.81));
  CHECK(added(gravity, y, UnitMass{})[2] == -9.81);
  CHECK(added(gravity, y, DenseMass<double>{m.asDiagonal()})[5] == Approx(-5 * 9.81));
  CHECK(added(uniform, y, masses)[5] == -9.81);
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
  SecondOrder<Dynamic> c;  // six components: neither 4 nor 5 fit
  const auto step = [&](auto force) {
    PhiStepper stepper{c.state, force, forward_euler};
    static_cast<void>(stepper.step(c.state, 0, 0.1));
  };
  CHECK_THROWS_AS(step(Gravity{Eigen::Vector4d::Ones()}), std::invalid_argument);
  CHECK_THROWS_AS(step(UniformForce{Eigen::VectorXd::Ones(5)}), std::invalid_argument);
  CHECK_THROWS_AS(step(UniformForce{Eigen::VectorXd(0)}), std::invalid_argument);
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
