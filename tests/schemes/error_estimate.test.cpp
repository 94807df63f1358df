// What a step says of its own error, against the truth.
#include "schemes/error_estimate_cases.hpp"
#include "support/shared_force.hpp"

using namespace error_estimate_cases;

using OfState = shared_force::OfState<Vec>;
const auto spring = [](const Vec& r) -> Vec { return -(4 + r.squaredNorm()) * r; };

TEST_CASE("first order: the estimate tends to the error, at every φ, by every way") {
  const Vec start = Flow::exact(0.3);
  for (const double p : {0.0, 0.25, 0.5, 0.7, 1.0}) {
    CAPTURE(p);
    check(flow(phi(p)), start, 0.04);
  }
  check(flow(tr_bdf2), start, 0.04);
  check(flow(midpoint), start, 0.04);  // by step doubling
}

TEST_CASE("motion with drag: the same, for r and for v") {
  check(
      [](const Motion<Vec>& y) {
        return PhiStepper{y, Swing{}, trapezoidal, mass(Swing::mass)};
      },
      Swing::exact(0.3), 0.04);
}

TEST_CASE("Verlet without drag, masses of every kind, split scenes") {
  check(
      [](const Motion<Vec>& y) {
        return PhiStepper{y, OfState(spring), velocity_verlet};
      },
      Motion<Vec>{Vec(1, 0.2), Vec(0.7, 0.8)}, 0.02);
}

TEST_CASE("slopes are those of the solution") { check_slopes(flow(tr_bdf2), Flow::exact(0.3)); }

TEST_CASE("a stiff component at rest does not rule the step") { check_stiff_at_rest(tr_bdf2); }

TEST_CASE("exact counts: an affine problem with known factors, accepted and rejected") {
  check_affine_counts(Eigen::Vector3d(1, 1, 1), Eigen::Matrix3d(-Eigen::Matrix3d::Identity()));
}

TEST_CASE("exact counts: explicit schemes, one call a try") {
  const OfState linear_spring = [](const Vec& r) -> Vec { return -9 * r; };
  // Verlet's Ψ(t) is gone with the rejected step, which used its place.
  CHECK(calls_of_ten(velocity_verlet, linear_spring) <= 30);
}
