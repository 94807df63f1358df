// What a step says of its own error, against the truth.
#include "schemes/error_estimate_cases.hpp"
#include "support/shared_force.hpp"

using namespace error_estimate_cases;

using OfState = shared_force::OfState<Vec>;
const auto spring = [](const Vec& r) -> Vec { return -(4 + r.squaredNorm()) * r; };

TEST_CASE("first order: the estimate tends to the error, at every φ, by every way") {
  const auto with = [](auto scheme) {
    return [scheme](const Vec& y) { return PhiStepper{y, Flow{}, scheme, capacity(Flow::capacity)}; };
  };
  const Vec start = Flow::exact(0.3);
  for (const double p : {0.0, 0.25, 0.5, 0.7, 1.0}) {
    CAPTURE(p);
    check(with(phi(p)), start, 0.04);
  }
  check(with(tr_bdf2), start, 0.04);
  check(with(midpoint), start, 0.04);  // by step doubling
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

TEST_CASE("slopes are those of the solution") {
  Vec y = Flow::exact(0.3);
  PhiStepper stepper{y, Flow{}, tr_bdf2, capacity(Flow::capacity)}, other = stepper;
  Trace<Vec> trace;
  trace.resize(y);
  double t = 0.3;
  for (int n = 0; n < 4; ++n) {
    Vec start = y, end = y;
    REQUIRE(other.slope(t, y, start));
    REQUIRE(stepper.attempt(y, t, 0.01, Origin::unknown, trace, yes));
    t += 0.01;
    REQUIRE(other.slope(t, y, end));
    REQUIRE(trace.has_slopes);
    // By the scheme's relations: exact but for Newton's rounding over φΔt.
    CHECK(distance(trace.start, start) <= 1e-11);
    CHECK(distance(trace.end, end) <= 1e-11);
    CHECK(trace.dt == 0.01);
    trace.advance();
    CHECK(trace.knows_start);
    CHECK(trace.dt_before == 0.01);
  }
}

TEST_CASE("a stiff component at rest does not rule the step") {
  // y0' = −λ (y0 − cos t) is at its limit long since; y1' = −y1. An explicit difference of slopes, Δt λ·noise, would.
  const auto steps = [](double lambda) {
    const auto force = [lambda](const Vec& y, double t) -> Vec { return Vec(-lambda * (y[0] - std::cos(t)), -y[1]); };
    Vec y(1, 1);
    PhiStepper stepper{y, force, tr_bdf2};
    const RunReport report = integrate(stepper, y, {0, 3}, tolerance{.rtol = 1e-4});
    REQUIRE(report);
    CHECK(y[1] == Approx(std::exp(-3)).epsilon(2e-3));
    if (lambda > 1) CHECK(y[0] == Approx(std::cos(3) + std::sin(3) / lambda).epsilon(2e-3));  // … + O(λ⁻²)
    return report.statistics.steps;
  };
  const auto mild = steps(1), stiff = steps(1e3), very = steps(1e7);
  CAPTURE(mild, stiff, very);
  CHECK(stiff <= 2 * mild);
  CHECK(very <= 2 * mild);
}

TEST_CASE("exact counts: an affine problem with known factors, accepted and rejected") {
  // Trapezoidal, affine: Ψ at the start from the last slope, one solve, one more for the filter. The affine path looks at
  // its residual (one call) before each solve, and after solves 1, 2, 4, 8, … since its matrix was made.
  using V = Eigen::Vector3d;
  const Eigen::Matrix3d K = -Eigen::Matrix3d::Identity();
  V y = V::Ones();
  PhiStepper stepper{y, linear(K), tr_bdf2};
  Trace<V> trace;
  trace.resize(y);
  trace.newton_target = 0.03;
  trace.weight.setConstant(1e6);
  Statistics before;
  const auto spent = [&](bool accept, double t) {
    before = stepper.statistics();
    const StepReport done =
        stepper.attempt(y, t, 0.01, Origin::unknown, trace, [accept](const auto&...) { return accept; });
    CHECK(static_cast<bool>(done) == accept);
    if (accept) trace.advance();
    return stepper.statistics() - before;
  };
  const Statistics first = spent(true, 0);
  CHECK(first.steps == 1);
  CHECK(first.factorizations == 1);
  CHECK(first.solves == 3);           // two resolves and the filter
  CHECK(first.force_calls == 1 + 4);  // y', each resolve's residual, and a look after solves 1 and 2
  const Statistics second = spent(true, 0.01);
  CHECK(second.factorizations == 0);
  CHECK(second.solves == 3);
  CHECK(second.force_calls == 2 + 1);  // y' is known; a look after solve 4
  const Statistics rejected = spent(false, 0.02);
  CHECK(rejected.steps == 0);
  CHECK(rejected.rejections == 1);
  CHECK(rejected.failed_steps == 0);
  CHECK(rejected.factorizations == 0);
  CHECK(rejected.force_calls == 2);
  CHECK(rejected.solves == 3);
}

TEST_CASE("exact counts: explicit schemes, one call a try") {
  const OfState linear_spring = [](const Vec& r) -> Vec { return -9 * r; };
  Motion<Vec> y{Vec(1, 0), Vec(0, 1)};
  const auto count = [&] {
    PhiStepper stepper{y, linear_spring, velocity_verlet};
    Trace<Motion<Vec>> trace;
    trace.resize(y);
    REQUIRE(stepper.attempt(y, 0, 0.01, Origin::unknown, trace, yes));
    trace.advance();
    const Statistics start = stepper.statistics();
    for (int n = 0; n < 10; ++n) {
      CHECK_FALSE(stepper.attempt(y, 0, 0.02, Origin::unknown, trace, [](const auto&...) { return false; }));
      REQUIRE(stepper.attempt(y, 0, 0.01, Origin::unknown, trace, yes));
      trace.advance();
    }
    const Statistics s = stepper.statistics() - start;
    CHECK(s.steps == 10);
    CHECK(s.rejections == 10);
    CHECK(s.solves + s.jacobians + s.iterations == 0);
    return s.force_calls;
  };
  // Verlet's Ψ(t) is gone with the rejected step, which used its place.
  CHECK(count() <= 30);
}
