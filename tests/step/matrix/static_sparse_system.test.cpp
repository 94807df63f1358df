// Systems whose pattern is known at compile time.
#include "step/matrix/static_sparse_system_cases.hpp"

using namespace static_sparse_cases;

namespace {

template <class F>
Vec end(F f) {
  Vec y = start();
  PhiStepper stepper{y, f, backward_euler};
  for (int k = 0; k < 50; ++k)
    if (const auto report = stepper.step(y, 0.02 * k, 0.02); !report) throw std::runtime_error(report.message());
  return y;
}

}  // namespace

TEST_CASE("a force that names its Jacobian's pattern is solved by it, and to the same answer") {
  const Vec dense = end(Dense{});
  // The same steps but for rounding, which 50 steps and a condition of 1e3 make 1e-11 at most.
  CHECK((end(Returned{}) - dense).cwiseAbs().maxCoeff() < 1e-11);
  CHECK((end(Added{}) - dense).cwiseAbs().maxCoeff() < 1e-11);
  Vec y = start();
  const std::string_view by_pattern = "LU by a pattern known at compile time";
  CHECK(std::string_view(PhiStepper{y, Returned{}, backward_euler}.solver_name()) == by_pattern);
  CHECK(std::string_view(PhiStepper{y, Added{}, backward_euler}.solver_name()) == by_pattern);
  CHECK(std::string_view(PhiStepper{y, Dense{}, backward_euler}.solver_name()) == "dense LU");
}

TEST_CASE("an affine force with a pattern: one factorization, and a wrong matrix shows") {
  Vec y = start();
  PhiStepper stepper{y, Conserving{}, backward_euler};
  for (int k = 0; k < 4; ++k) REQUIRE(stepper.step(y, 0.1 * k, 0.1));
  CHECK(stepper.statistics().factorizations == 1);
  CHECK(y.sum() == Approx(start().sum()).epsilon(1e-14));
  const Vec before = y;
  Conserving wrong;
  wrong.error = 1e-3;
  PhiStepper other{y, wrong, backward_euler};
  CHECK(other.step(y, 0.0, 0.1).outcome() == Outcome::not_affine);
  CHECK(y == before);
}

TEST_CASE("a Jacobian with entries outside of its pattern is refused, the state untouched") {
  Vec y = start();
  const Vec before = y;
  PhiStepper stepper{y, Forgotten{}, backward_euler};
  CHECK_THROWS_WITH(stepper.step(y, 0.0, 0.1), contains("jacobian_pattern"));
  CHECK(y == before);
}
