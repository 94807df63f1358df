// What a step says of its own error, by every scheme and mass; the quick half is error_estimate.test.cpp.
#include "schemes/error_estimate_cases.hpp"

using namespace error_estimate_cases;

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
  const auto check_slopes = [](auto make, auto y) {
    using S = decltype(y);
    auto stepper = make(y), other = make(y);
    Trace<S> trace;
    trace.resize(y);
    double t = 0.3;
    for (int n = 0; n < 4; ++n) {
      S start = y, end = y;
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
  };
  const auto flow = [](auto scheme) {
    return [scheme](const Vec& y) { return PhiStepper{y, Flow{}, scheme, capacity(Flow::capacity)}; };
  };
  const auto swing = [](auto scheme) {
    return [scheme](const Motion<Vec>& y) { return PhiStepper{y, Swing{}, scheme, mass(Swing::mass)}; };
  };
  check_slopes(flow(forward_euler), Flow::exact(0.3)), check_slopes(flow(phi(0.25)), Flow::exact(0.3));
  check_slopes(flow(trapezoidal), Flow::exact(0.3)), check_slopes(flow(backward_euler), Flow::exact(0.3));
  check_slopes(flow(tr_bdf2), Flow::exact(0.3)), check_slopes(swing(trapezoidal), Swing::exact(0.3));
  check_slopes(swing(velocity_verlet), Swing::exact(0.3)), check_slopes(swing(tr_bdf2), Swing::exact(0.3));
}

TEST_CASE("a stiff component at rest does not rule the step") {
  // y0' = −λ (y0 − cos t) is at its limit long since; y1' = −y1. An explicit difference of slopes, Δt λ·noise, would.
  const auto steps = [](double lambda, auto scheme) {
    const auto force = [lambda](const Vec& y, double t) -> Vec { return Vec(-lambda * (y[0] - std::cos(t)), -y[1]); };
    Vec y(1, 1);
    PhiStepper stepper{y, force, scheme};
    const RunReport report = integrate(stepper, y, {0, 3}, tolerance{.rtol = 1e-4});
    REQUIRE(report);
    CHECK(y[1] == Approx(std::exp(-3)).epsilon(2e-3));
    if (lambda > 1) CHECK(y[0] == Approx(std::cos(3) + std::sin(3) / lambda).epsilon(2e-3));  // … + O(λ⁻²)
    return report.statistics.steps;
  };
  const auto check_scheme = [&](auto scheme) {
    const auto mild = steps(1, scheme), stiff = steps(1e3, scheme), very = steps(1e7, scheme);
    CAPTURE(mild, stiff, very);
    CHECK(stiff <= 2 * mild);
    CHECK(very <= 2 * mild);
  };
  check_scheme(tr_bdf2), check_scheme(backward_euler), check_scheme(phi(0.7)), check_scheme(trapezoidal);
}

TEST_CASE("exact counts: an affine problem with known factors, accepted and rejected") {
  // Trapezoidal, affine: Ψ at the start from the last slope, one solve, one more for the filter. The affine path looks at
  // its residual (one call) before each solve, and after solves 1, 2, 4, 8, … since its matrix was made.
  using V = Eigen::VectorXd;
  const Eigen::MatrixXd K = -Eigen::MatrixXd::Identity(3, 3);
  V y = V::Ones(3);
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
  const auto spring = [](const Vec& r) -> Vec { return -9 * r; };
  Motion<Vec> y{Vec(1, 0), Vec(0, 1)};
  const auto count = [&](auto scheme) {
    PhiStepper stepper{y, spring, scheme};
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
  CHECK(count(forward_euler) == 20);
  // Verlet's Ψ(t) is gone with the rejected step, which used its place.
  CHECK(count(velocity_verlet) <= 30);
}
