// symmetric_sparse_system behind a stepper: nets. In short: systems.test.cpp.
#include "linear/sparse/symmetric_sparse_system_cases.hpp"

using namespace symmetric_sparse_cases;

TEST_CASE("a stretched net: definite, no fallback, the same steps as by LU") {
  auto by_ldlt = SpringNet::start(), by_lu = by_ldlt;
  const auto masses = mass(SpringNet::masses());
  const Statistics s = steps(by_ldlt, symmetric(by_entries(SpringNet::elastic())), trapezoidal, 20, 0.05, masses);
  const Statistics lu = steps(by_lu, by_entries(SpringNet::elastic()), trapezoidal, 20, 0.05, masses);
  CHECK(s.fallbacks == 0);
  CHECK(s.analyses == 1);
  CHECK(s.iterations == lu.iterations);
  // Both iterate to rounding: a few units in the last place of a state of size 3 in each step.
  CHECK((by_ldlt.r - by_lu.r).cwiseAbs().maxCoeff() <= 20 * 8 * 3 * 2.3e-16);
}

TEST_CASE("a compressed net in a long step: indefinite matrices are solved by LU, and counted") {
  auto by_ldlt = pressed(), by_lu = by_ldlt;
  const auto masses = mass(SpringNet::masses());
  PhiStepper stepper{by_ldlt, symmetric(by_entries(SpringNet::elastic())), backward_euler, masses};
  PhiStepper reference{by_lu, by_entries(SpringNet::elastic()), backward_euler, masses};
  const StepReport report = stepper.step(by_ldlt, 0, 0.6), expected = reference.step(by_lu, 0, 0.6);
  INFO(report.message() << "\n" << expected.message());
  REQUIRE(expected);
  REQUIRE(report);
  CHECK(stepper.statistics().fallbacks > 0);
  CHECK(stepper.statistics().analyses == 2);  // one for each of the two solvers
  CHECK(stepper.statistics().iterations == reference.statistics().iterations);
  CHECK((by_ldlt.r - by_lu.r).cwiseAbs().maxCoeff() <= 1e-13);
  // The same net in a short step is definite again: LDLᵀ serves.
  const std::int64_t fallbacks = stepper.statistics().fallbacks;
  REQUIRE(stepper.step(by_ldlt, 0.6, 1e-3));
  CHECK(stepper.statistics().fallbacks == fallbacks);
  CHECK(stepper.statistics().analyses == 2);
}

TEST_CASE("who names SimplicialLDLT gets it, and is told that the matrix is indefinite") {
  auto y = pressed();
  const auto before = y;
  PhiStepper stepper{y, symmetric(by_entries(SpringNet::elastic())), backward_euler, mass(SpringNet::masses()),
                     newton<Eigen::SimplicialLDLT<Sparse>>()};
  CHECK(stepper.step(y, 0, 0.6).outcome() == Outcome::not_positive_definite);
  CHECK(stepper.statistics().fallbacks == 0);
  CHECK(same_motion(y, before));
}

TEST_CASE("a copy of a stepper has solvers of its own, and goes on with the same digits") {
  auto y = SpringNet::start();
  PhiStepper stepper{y, symmetric(by_entries(SpringNet::elastic())), trapezoidal, mass(SpringNet::masses())};
  REQUIRE(stepper.step(y, 0, 0.05));
  auto copy = stepper;
  auto other = y;
  REQUIRE(copy.step(other, 0.05, 0.05));
  REQUIRE(stepper.step(y, 0.05, 0.05));
  CHECK((y.r - other.r).cwiseAbs().maxCoeff() <= 8 * 3 * 2.3e-16);
}
