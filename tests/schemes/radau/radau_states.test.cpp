// Radau IIA steps of every kind of state, with every kind of mass; units; failures.
#include <phistep/phistep.hpp>
#include <phistep/schemes/radau/radau.hpp>

#include <limits>

#include "problems/march.hpp"
#include "problems/van_der_pol.hpp"
#include "support/catch.hpp"

using namespace phistep;
using problems::distance;

TEST_CASE("backward and forward again, and from one time to another in two lengths") {
  const auto y = problems::VanDerPol::start();
  auto now = y;
  PhiStepper stepper{y, problems::VanDerPol{}, radau(7)};
  problems::step(stepper, now, 0.0, 0.1);
  problems::step(stepper, now, 0.1, -0.1);
  CHECK(distance(now, y) <= 1e-10);  // each way is right to order 13
}

TEST_CASE("failures leave the state as it was, and name themselves") {
  using V = Eigen::Vector2d;
  double poison = 0;
  const auto f = [&poison](const V& y) -> V { return {-y[0] + poison, -y[1] * y[1]}; };
  V y{1, 1};
  PhiStepper stepper{y, f, radau(3)};
  problems::step(stepper, y, 0.0, 0.1);
  const V before = y;
  poison = std::numeric_limits<double>::quiet_NaN();
  const StepReport report = stepper.step(y, 0.1, 0.1);
  CHECK(report.outcome() == Outcome::non_finite_force);
  CHECK(report.failure().index == 0);
  CHECK(y == before);
  poison = 0;
  // 1/λ₀ h J = 1: the real lane is singular.
  struct Growth {
    double lambda;
    Eigen::Matrix<double, 1, 1> operator()(const Eigen::Matrix<double, 1, 1>& x) const { return lambda * x; }
    Eigen::Matrix<double, 1, 1> jacobian(const Eigen::Matrix<double, 1, 1>&) const {
      return Eigen::Matrix<double, 1, 1>{lambda};
    }
  };
  Eigen::Matrix<double, 1, 1> x{1};
  const double lambda0 = radau_constants<double, 3>.lambda.re[0];
  CHECK(PhiStepper{x, Growth{lambda0}, radau(3)}.step(x, 0, 1).outcome() == Outcome::singular_matrix);
  CHECK(x[0] == 1);
  CHECK_THROWS_AS(radau(4), std::invalid_argument);
}
