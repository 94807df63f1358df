// A ball that loses nothing bounces on the ground by Verlet.
#include <phistep/particles.hpp>
#include <phistep/preflight.hpp>

#include <algorithm>
#include <cmath>

#include "instances/preflight.hpp"
#include "support/catch.hpp"

using namespace phistep;

namespace {

using Vec = Eigen::Vector3d;
using Balls = Particles<double, 3>;

bool says_so(const PreflightReport& report) { return report.verdict != Verdict::fine || !report.finding.empty(); }

/// A ball that loses nothing bounces on the ground for a minute by Verlet: it keeps its height, or preflight, asked while
/// it falls, says that the step is too long.
bool is_said_or_keeps_height(double steps_per_impact) {
  const double m = 0.01, R = 0.01, k = 1e4, g = 9.81, h = 0.1, dt = M_PI * std::sqrt(m / k) / steps_per_impact;
  Balls y{Vec{0, 0, R + h}};
  y.set_mass(m).set_radius(R);
  PhiStepper stepper{y, Gravity{Vec{0, 0, -g}} + Walls{Hooke{.stiffness = k}, Plane<3>{{0, 0, 0}, {0, 0, 1}}},
                     velocity_verlet};
  double v = 0, lowest = 1, highest = 0;
  const auto look = [&](double, const Balls& now) {
    if (now.r(2, 0) <= R) return;
    if (v < 0 && now.v(2, 0) > 0) {
      const double height = (now.r(2, 0) - R + now.v(2, 0) * now.v(2, 0) / 2 / g) / h;
      lowest = std::min(lowest, height), highest = std::max(highest, height);
    }
    v = now.v(2, 0);
  };
  REQUIRE(integrate(stepper, y, {0.0, 60.0}, fixed(dt), look));
  Balls falls{Vec{0, 0, 2 * R}, Vec{0, 0, -1}};
  falls.set_mass(m).set_radius(R);
  const bool said = says_so(preflight(stepper, falls, dt));
  CAPTURE(lowest, highest, said);
  return said || (lowest > 0.97 && highest < 1.03);
}

}  // namespace

TEST_CASE("Verlet's bounces keep their height at 1/20 of an impact, or preflight says so") {
  CHECK(is_said_or_keeps_height(20));
}
TEST_CASE("Verlet's bounces keep their height at 1/7 of an impact, or preflight says so") {
  CHECK(is_said_or_keeps_height(7.3));
}
