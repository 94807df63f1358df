#include <phistep/phistep.hpp>

#include "problems/dae.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

TEST_CASE("algebraic components follow from those with mass") {
  using Problem = problems::CartesianPendulum;
  Problem::State y{0.6, -0.8, 0.8, 0.6, 0};
  PhiStepper stepper{y, problems::AutonomousDaeForce<Problem>{}, rodas4, capacity(Problem::mass())};
  CHECK(stepper.step(y, 0, 0.01).outcome() == Outcome::inconsistent_start);
  const ConsistentReport report = make_consistent(stepper, y, 0);
  REQUIRE(report);
  CHECK(y.head<4>() == Eigen::Vector4d(0.6, -0.8, 0.8, 0.6));
  CHECK(y[4] == Approx(1 + 0.8 * 9.81).epsilon(1e-14));  // v² − g y over r²
  CHECK(report.iterations <= 3);
  CHECK(stepper.step(y, 0, 0.01));
}

TEST_CASE("components that the user names stay, all others follow") {
  // Robertson: y₁ and y₃ given, y₂ is what is left.
  using Problem = problems::RobertsonDae;
  Problem::State y{0.9, 0.5, 0.09};
  PhiStepper stepper{y, problems::AutonomousDaeForce<Problem>{}, rodas4, capacity(Problem::mass())};
  REQUIRE(make_consistent(stepper, y, 0, {.fixed = {0, 2}}));
  CHECK(y[0] == 0.9);
  CHECK(y[2] == 0.09);
  CHECK(y[1] == Approx(0.01).epsilon(1e-12));
  const Problem::State before = y;
  y[2] = 0.5;
  const Problem::State edited = y;
  const ConsistentReport fails = make_consistent(stepper, y, 0, {.fixed = {0}});  // one equation for two
  CHECK(fails.outcome == Outcome::singular_matrix);
  CHECK(y == edited);
  CHECK(make_consistent(stepper, y, 0, {.fixed = {0, 1, 2}}).outcome ==
        Outcome::singular_matrix);  // nothing may change
  CHECK(y == edited);
  CHECK_THROWS_AS(make_consistent(stepper, y, 0, {.fixed = {0, 7}}), std::invalid_argument);
  CHECK(before.sum() == Approx(1).epsilon(1e-15));
}

TEST_CASE("of a mass matrix without rows of zeros, M y stays") {
  using Problem = problems::TransistorAmplifier;
  Problem::State y = Problem::start();
  y[1] += 0.3, y[3] -= 1, y[6] += 0.2;
  const auto M = Problem::mass();
  const Problem::State before = M * y;
  PhiStepper stepper{y, problems::DaeForce<Problem>{}, rodas4, capacity(M)};
  CHECK(stepper.step(y, 0, 1e-5).outcome() == Outcome::inconsistent_start);
  REQUIRE(make_consistent(stepper, y, 0));
  CHECK((M * y - before).norm() <= 1e-12 * before.norm());
  CHECK(stepper.step(y, 0, 1e-5));
}

TEST_CASE("steep algebraic equations are solved by damped steps") {
  // 0 = exp(20 z) − y, from z = 2: exp(40).
  Eigen::Vector2d y{1, 2};
  const auto steep = [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return {-x[0], std::exp(20 * x[1]) - x[0]}; };
  PhiStepper stepper{y, steep, rodas4, capacity(Eigen::Vector2d(1, 0))};
  const ConsistentReport report = make_consistent(stepper, y, 0);
  REQUIRE(report);
  CHECK(std::abs(y[1]) <= 1e-14);
  // The other way there is nothing to be found: 0 = exp(z) + y.
  const auto none = [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return {-x[0], std::exp(x[1]) + x[0]}; };
  PhiStepper nowhere{y, none, rodas4, capacity(Eigen::Vector2d(1, 0))};
  y = {1, 0};
  const ConsistentReport fails = make_consistent(nowhere, y, 0);
  CHECK(!fails);
  CHECK(y == Eigen::Vector2d(1, 0));
  CHECK_THAT(fails.message(), contains("make_consistent"));
}

TEST_CASE("a force that is not finite, an index above one and a regular mass are told") {
  Eigen::Vector2d y{1, 1};
  const Eigen::Vector2d M{1, 0};
  const auto index_two = [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return {x[1], x[0] - 2}; };
  PhiStepper two{y, index_two, rodas4, capacity(M)};
  const ConsistentReport singular = make_consistent(two, y, 0);
  CHECK(singular.outcome == Outcome::singular_matrix);
  CHECK_THAT(singular.message(), contains("index is higher than one"));
  const auto nan = [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return {x[1], std::sqrt(-x[0])}; };
  PhiStepper broken{y, nan, rodas4, capacity(M)};
  CHECK(make_consistent(broken, y, 0).outcome == Outcome::non_finite_force);
  PhiStepper regular{y, index_two, rodas4, capacity(Eigen::Vector2d(1, 1))};
  CHECK_THROWS_AS(make_consistent(regular, y, 0), std::invalid_argument);
}
