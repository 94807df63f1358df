// What a step says of its own error, against the truth.
#include "schemes/error_estimate_cases.hpp"
#if PHISTEP_QUICK
#include "support/shared_force.hpp"
#endif

using namespace error_estimate_cases;

#if PHISTEP_QUICK

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

#elif PHISTEP_FULL
// What a step says of its own error, by every scheme and mass.

TEST_CASE("Verlet without drag, masses of every kind, split scenes") {
  using S = Motion<Vec>;
  const auto spring = [](const Vec& r) -> Vec { return -(4 + r.squaredNorm()) * r; };
  const S start{Vec(1, 0.2), Vec(0.7, 0.8)};  // nothing small: a vanishing r‴ would have no leading error
  const Eigen::Matrix2d M{{2, 0.5}, {0.5, 1}};
  const auto all = [&](auto scheme) {
    check([&](const S& y) { return PhiStepper{y, spring, scheme}; }, start, 0.02);
    check([&](const S& y) { return PhiStepper{y, spring, scheme, mass(Vec(0.5, 2))}; }, start, 0.02);
    check([&](const S& y) { return PhiStepper{y, spring, scheme, mass(Eigen::MatrixXd(M))}; }, start, 0.02);
    check([&](const S& y) { return PhiStepper{y, Swing{}, scheme, mass(Eigen::MatrixXd(M))}; }, start, 0.02);
  };
  all(velocity_verlet), all(trapezoidal), all(tr_bdf2), all(backward_euler);
  const auto drag = [](const Vec& r, const Vec& v) -> Vec { return -r - 0.3 * v; };
  check([&](const S& y) { return PhiStepper{y, term(spring) + at(forward_euler, term(drag)), midpoint}; }, start, 0.02);
  check(
      [&](const S& y) {
        return PhiStepper{y, term(spring) + at(forward_euler, term(drag)), trapezoidal};
      },
      start, 0.02);
}

TEST_CASE("slopes are those of the solution") {
  const auto swing = [](auto scheme) {
    return [scheme](const Motion<Vec>& y) { return PhiStepper{y, Swing{}, scheme, mass(Swing::mass)}; };
  };
  check_slopes(flow(forward_euler), Flow::exact(0.3)), check_slopes(flow(phi(0.25)), Flow::exact(0.3));
  check_slopes(flow(trapezoidal), Flow::exact(0.3)), check_slopes(flow(backward_euler), Flow::exact(0.3));
  check_slopes(flow(tr_bdf2), Flow::exact(0.3)), check_slopes(swing(trapezoidal), Swing::exact(0.3));
  check_slopes(swing(velocity_verlet), Swing::exact(0.3)), check_slopes(swing(tr_bdf2), Swing::exact(0.3));
}

TEST_CASE("a stiff component at rest does not rule the step") {
  check_stiff_at_rest(tr_bdf2), check_stiff_at_rest(backward_euler);
  check_stiff_at_rest(phi(0.7)), check_stiff_at_rest(trapezoidal);
}

TEST_CASE("exact counts: an affine problem with known factors, accepted and rejected") {
  check_affine_counts(Eigen::VectorXd(Eigen::VectorXd::Ones(3)), Eigen::MatrixXd(-Eigen::MatrixXd::Identity(3, 3)));
}

TEST_CASE("exact counts: explicit schemes, one call a try") {
  const auto spring = [](const Vec& r) -> Vec { return -9 * r; };
  CHECK(calls_of_ten(forward_euler, spring) == 20);
  // Verlet's Ψ(t) is gone with the rejected step, which used its place.
  CHECK(calls_of_ten(velocity_verlet, spring) <= 30);
}

#endif
