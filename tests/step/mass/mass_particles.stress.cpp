// A mass per particle in states of all shapes. In short: mass.test.cpp.
#include "step/mass/mass_cases.hpp"

using namespace mass_cases;

TEMPLATE_TEST_CASE("a mass per particle is its components' mass", "", SecondOrder<FixedColumns>, SecondOrder<Structs>,
                   FirstOrder<RowMajor>) {
  const Eigen::Vector2d particles(2, 5);
  Eigen::VectorXd components(6);
  components << 2, 2, 2, 5, 5, 5;
  using Flat = std::conditional_t < requires(TestType c) { c.state.r; }
  , SecondOrder<Dynamic>, FirstOrder < Dynamic >> ;
  const auto check = [&](auto scheme) {
    CHECK(distance(run<TestType>(scheme, mass(particles)), run<Flat>(scheme, mass(components))) <= 1e-13);
  };
  check(forward_euler), check(phi(0.7));
}
