// Of the stress list what is quick: ratios of masses, matrices without an inverse, the floor of precision, denormal
// numbers. Implicit springs, products with the matrix, tangents that are indefinite: stress_list.full.cpp. All of it,
// at full length: extremes.stress.cpp and solvers.stress.cpp.
#include <cmath>
#include <stdexcept>

#include "extremes/stress_list_cases.hpp"
#include "support/shared_force.hpp"

using namespace stress_list_cases;
using Two = Eigen::Vector2d;

TEST_CASE("stress list: mass ratio 1e12") { check_dumbbell(velocity_verlet); }

TEST_CASE("stress list: matrices without an inverse") {
  check_without_inverse<Two>();
  // Neither has M, be it of its numbers or for a reciprocal that is no number (tests/step/mass/mass.test.cpp: matrices).
  for (const double bad : {0.0, -1.0, 1e-320, std::nan(""), HUGE_VAL}) {
    CHECK_THROWS_AS(mass(bad), std::invalid_argument);
    const auto stepper = [bad] {
      PhiStepper{Vec::Ones(2).eval(), linear(Eigen::MatrixXd::Identity(2, 2).eval()), trapezoidal,
                 mass(Vec(bad * Vec::Ones(2)))};
    };
    CHECK_THROWS_AS(stepper(), std::invalid_argument);
  }
}

TEST_CASE("stress list: time at the floor of its precision") { check_floor_of_time(Two::Zero().eval()); }

TEST_CASE("stress list: denormal numbers") {
  constexpr double tiny = 1e-310;
  // A drift at a denormal speed, and a fall from rest by a denormal force: right, or flushed to zero by the machine.
  Motion<Vec> y{Vec::Ones(3), Vec::Constant(3, tiny)};
  PhiStepper stepper{y, [](const Vec& r) -> Vec { return Vec::Zero(r.size()); }, velocity_verlet};
  for (int n = 0; n < 100; ++n) REQUIRE(stepper.step(y, n, 1));
  CHECK((y.r == Vec::Ones(3) && y.v == Vec::Constant(3, tiny)));
  check_denormal_parts<Two>(shared_force::OfStateAndTime<Two>{[](const Two& x, double) -> Two { return -x; }});
}
