// Heat without a matrix by every solver; in short: tangent_product.test.cpp.
#include <phistep/krylov.hpp>

#include "linear/krylov/tangent_product_cases.hpp"

using namespace tangent_product_cases;

TEMPLATE_TEST_CASE("heat on 100 x 100 points without a matrix: the exact factor of an eigenvector", "", (MatrixFree<>),
                   (MatrixFree<KrylovMethod::conjugate_gradients>), (MatrixFree<KrylovMethod::gmres>)) {
  constexpr Index m = 100;
  Counts c;
  const double dt = 1e-3;
  const double z = eigenvalue(m, 2, 3) * dt, w = eigenvalue(m, 7, 1) * dt;
  const Vec a = mode(m, 2, 3), b = 0.5 * mode(m, 7, 1);
  const auto run = [&](auto force, double tolerance) {
    Vec y = a + b;
    PhiStepper stepper{y, force, backward_euler, newton<TestType>()};
    for (int k = 1; k <= 3; ++k) {
      const StepReport report = stepper.step(y, 0, dt);
      INFO(report.message());
      REQUIRE(report);
      const Vec exact = std::pow(1 - z, -k) * a + std::pow(1 - w, -k) * b;
      CHECK((y - exact).norm() <= tolerance * exact.norm());
    }
    const Statistics s = stepper.statistics();
    CHECK(s.jacobians + s.factorizations == 0);
    CHECK(s.linear_iterations > 0);
    CHECK(s.solves == s.iterations);
    CHECK(s.force_calls == c.calls);
    return s;
  };
  // Rounding: W's condition number is 1 + 8·101²·dt = 83.
  SECTION("products from the force") {
    const Statistics s = run(HeatWithProduct{{m, &c.calls, &c.products}}, 1e-13);
    CHECK(s.force_calls == s.iterations);
    CHECK(c.products >= s.linear_iterations);
  }
  SECTION("preconditioned by W's diagonal") {
    const Statistics s = run(HeatWithDiagonal{{{m, &c.calls, &c.products}}}, 1e-13);
    CHECK(s.force_calls == s.iterations);
  }
  SECTION("products by differences: one force call each") {
    const Statistics s = run(Heat2d{m, &c.calls, &c.products}, 1e-13);
    CHECK(s.force_calls >= s.iterations + s.linear_iterations);
  }
}
