// jacobian: the full product and what is dear to compile. The quick half is jacobian.test.cpp.
#include "step/jacobian/jacobian_cases.hpp"

using namespace jacobian_cases;

TEST_CASE("check_jacobian works on views, matrices and at a time") {
  states::FirstOrder<states::Strided> strided;
  CHECK(check_jacobian(Timed{}, strided.state, 3.0));
}

TEST_CASE("automatic differentiation of a motion gives K and C at t") {
  CHECK(check_jacobian(damped_by_autodiff(), Motion<Eigen::Vector2d>{{1, 2}, {3, 4}}, 10.0));
}
