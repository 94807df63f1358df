// external_field: the full product and what is dear to compile. The quick half is external_field.test.cpp.
#include "force/external_field_cases.hpp"

using namespace external_field_cases;

TEST_CASE("a field's tangent is the user's, automatic, or of differences, and all steps agree") {
  const Motion<Eigen::Matrix3Xd> start{some_positions(), some_positions()};
  CHECK(check_jacobian(ExternalField{autodiff(quartic)} + LinearDrag{0.3}, start, 0.2));
  const auto steps = [&](auto field) {
    auto y = start;
    PhiStepper stepper{y, field, trapezoidal, mass(2.0)};
    for (int n = 0; n < 10; ++n) REQUIRE(stepper.step(y, 0.1 * n, 0.1));
    return std::pair{y.r, stepper.statistics().force_calls};
  };
  const auto analytic = steps(ExternalField{Analytic{}}), differences = steps(ExternalField{quartic});
  CHECK((analytic.first - differences.first).norm() <= 1e-10);
  CHECK(analytic.second < differences.second);
}

TEST_CASE("quadratic drag: against the velocity, with its square; its tangent") {
  const Motion<Eigen::VectorXd> plane{some_positions().reshaped(), some_positions().reshaped()};
  CHECK(check_jacobian(QuadraticDrag<2>{0.7}, plane));
  // At rest there is neither force nor tangent.
  const Motion<Eigen::Matrix3Xd> rest{some_positions(), Eigen::Matrix3Xd::Zero(3, 4)};
  auto state = rest;
  PhiStepper stepper{state, QuadraticDrag{0.7}, trapezoidal, mass(2.0)};
  REQUIRE(stepper.step(state, 0, 0.1));
  CHECK((state.r == rest.r));
}

TEST_CASE("quadratic drag brakes as 1/(1 + c v t/m)") {
  Motion<Eigen::Matrix3Xd> y{Eigen::Matrix3Xd::Zero(3, 1), Vector3d(3, 0, 4)};
  PhiStepper stepper{y, QuadraticDrag{0.5}, trapezoidal, mass(2.0)};
  const int n = 1000;
  for (int k = 0; k < n; ++k) REQUIRE(stepper.step(y, k * 1e-3, 1e-3));
  // v' = −(c/m) v²; order 2: h² v'''/12 ≈ 1e-6 · 6 (c/m)³ v⁴/12.
  CHECK(y.v.norm() == Approx(5 / (1 + 0.25 * 5)).margin(5e-6));
}
