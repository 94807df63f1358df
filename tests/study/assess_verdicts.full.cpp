// assess, its dear cases: verdicts of every scheme. In short: tests/study/preflight.test.cpp.
#include "study/assess_cases.hpp"

using namespace assess_cases;

TEST_CASE("verdicts") {
  const auto y = chain_state(20);
  const auto springs = spring_network<1>(chain(20, 400));  // ω ≈ 40
  const auto ask = [&](auto scheme, double dt, PreflightOptions options = {}) {
    PhiStepper stepper{y, springs, scheme};
    return preflight(stepper, y, dt, options);
  };
  CHECK(ask(velocity_verlet, 0.01).verdict == Verdict::fine);
  CHECK(ask(velocity_verlet, 0.01));
  CHECK(ask(velocity_verlet, 0.03).verdict == Verdict::coarse);
  CHECK(ask(velocity_verlet, 0.0502).verdict == Verdict::unstable);  // 2/39.88 = 0.05015
  CHECK(ask(velocity_verlet, 0.0500).verdict == Verdict::coarse);
  CHECK(ask(forward_euler, 1e-6).verdict == Verdict::unstable);
  CHECK(ask(forward_euler, 1e-6).stable_dt == 0);
  CHECK(mentions(ask(forward_euler, 1e-6), "Never stable"));
  CHECK(ask(phi(0.3), 1e-6).stable_dt == 0);
  CHECK(ask(phi(0.3, 0.6), 1e-6).stable_dt == 0);
  CHECK(ask(trapezoidal, 1.0).stable_dt == infinite);
  CHECK(ask(trapezoidal, 1.0).verdict == Verdict::coarse);
  CHECK(mentions(ask(trapezoidal, 1.0), "ring on by a factor 1 a step"));
  CHECK(mentions(ask(backward_euler, 1.0), "damps them by a factor 0.025"));  // 1/√(1 + 39.88²)
  CHECK(ask(backward_euler, 1.0).fastest_factor == Approx(1 / std::hypot(1, 39.877)).epsilon(1e-4));
  CHECK(ask(tr_bdf2, 0.02).verdict == Verdict::coarse);
  CHECK(ask(rannacher, 0.005).verdict == Verdict::fine);
  CHECK(ask(midpoint, 0.005).recommended.scheme == "midpoint");
  // What he wants to see is slow: then a step that does not resolve the rest is fine, and said to ring.
  const auto slow = ask(trapezoidal, 0.2, {.period = 10});
  CHECK(slow.verdict == Verdict::fine);
  CHECK(mentions(slow, "tr_bdf2 would damp"));
  CHECK(ask(velocity_verlet, 0.2, {.period = 100}).recommended.scheme == "velocity_verlet");
  CHECK(ask(velocity_verlet, 1.0, {.period = 100}).recommended.scheme == "tr_bdf2");
  CHECK(ask(velocity_verlet, 1.0, {.period = 100}).recommended.dt == 1.0);
  // Contacts: ten steps.
  CHECK(ask(velocity_verlet, 0.01, {.contact_time = 0.2}).verdict == Verdict::fine);
  CHECK(ask(velocity_verlet, 0.01, {.contact_time = 0.2}).steps_per_contact == Approx(20));
  CHECK(ask(velocity_verlet, 0.01, {.contact_time = 0.05}).verdict == Verdict::coarse);
  CHECK(mentions(ask(velocity_verlet, 0.01, {.contact_time = 0.05}), "ten steps a contact"));
  CHECK(ask(velocity_verlet, 0.01, {.contact_time = 0.05}).recommended.dt == Approx(0.005));
}

TEST_CASE("accuracy: what is foretold is what happens") {
  // One oscillator, ω = 2, a = 0.2: energy after a period, and the period by the phase reached.
  const auto run = [](auto scheme, double dt) {
    Motion y{Eigen::Matrix<double, 1, 1>{1}, Eigen::Matrix<double, 1, 1>{0}};
    PhiStepper stepper{y, linear(Eigen::Matrix<double, 1, 1>{-4}), scheme};
    const auto report = preflight(stepper, y, dt);
    const int steps = 2000;
    double angle = 0, last = 0, energy = 0;
    for (int n = 0; n < steps; ++n) {
      REQUIRE(stepper.step(y, n * dt, dt));
      const double now = std::atan2(-y.v[0] / 2, y.r[0]);
      angle += std::remainder(now - last, 2 * std::numbers::pi);
      last = now;
      energy = y.r[0] * y.r[0] + y.v[0] * y.v[0] / 4;
    }
    const double exact = 2 * dt * steps;
    // (r, v/ω) turns on an ellipse that is off a circle by at most a/2 (the pairs): so are its angle and log energy/2.
    const double a = 2 * dt;
    CHECK(report.phase_error == Approx(angle / exact - 1).epsilon(0.02).margin(a / 2 / exact));
    CHECK(std::log(report.energy_per_period) == Approx(std::log(energy) * std::numbers::pi / dt / steps)
                                                    .epsilon(1e-3)
                                                    .margin(a * std::numbers::pi / dt / steps));
    CHECK(report.steps_per_period == Approx(std::numbers::pi / dt));
    CHECK(report.period == Approx(std::numbers::pi));
    return report;
  };
  CHECK(run(trapezoidal, 0.1).phase_error == Approx(-0.04 / 12).epsilon(0.01));
  CHECK(run(velocity_verlet, 0.1).phase_error == Approx(0.04 / 24).epsilon(0.01));
  CHECK(run(phi(0.6), 0.1).added_damping == Approx(0.1 * 0.2).epsilon(0.02));
  CHECK(run(backward_euler, 0.01).added_damping == Approx(0.5 * 0.02).epsilon(0.01));
  run(tr_bdf2, 0.1);
  run(phi(0.3, 0.9), 0.1);
  run(symplectic_euler, 0.1);
}

TEST_CASE("first order: ringing, growth that a step would hide, consistent capacities") {
  const Eigen::Vector2d y{0, 0};
  const auto decay = [&](auto scheme, double dt) {
    PhiStepper stepper{y, linear(Eigen::Matrix2d(Eigen::Vector2d{-1, -1000}.asDiagonal())), scheme};
    return preflight(stepper, y, dt);
  };
  CHECK(decay(forward_euler, 1e-3).stable_dt == Approx(0.999 * 2e-3));
  CHECK(decay(forward_euler, 1.5e-3).rings);
  CHECK_FALSE(decay(forward_euler, 0.9e-3).rings);
  CHECK(decay(trapezoidal, 0.1).rings);
  CHECK(decay(trapezoidal, 0.1).fastest_factor == Approx(49.0 / 51));
  CHECK(decay(trapezoidal, 0.1).unringing_dt == Approx(2e-3));
  CHECK(mentions(decay(trapezoidal, 0.1), "ring on by a factor 0.961 a step"));
  CHECK(decay(backward_euler, 0.1).unringing_dt == infinite);
  CHECK(mentions(decay(backward_euler, 0.1), "damps them by a factor 0.0099"));
  CHECK(decay(tr_bdf2, 1e-4).unringing_dt == Approx((1 + std::sqrt(2)) * 1e-3));

  PhiStepper grows{y, linear(Eigen::Matrix2d(Eigen::Vector2d{-1, 30}.asDiagonal())), backward_euler};
  CHECK(preflight(grows, y, 1.0).growth == Approx(30));
  CHECK(mentions(preflight(grows, y, 1.0), "would hide it"));

  // Linear finite elements, M = Δx/6 (1 4 1), K = (1 −2 1)/Δx: the largest λ is 12/Δx².
  const int n = 300;
  std::vector<Eigen::Triplet<double>> stiffness, capacities;
  for (int i = 0; i < n; ++i)
    for (int j = std::max(0, i - 1); j < std::min(n, i + 2); ++j) {
      stiffness.emplace_back(i, j, i == j ? -2 : 1);
      capacities.emplace_back(i, j, i == j ? 4. / 6 : 1. / 6);
    }
  Sparse K(n, n), M(n, n);
  K.setFromTriplets(stiffness.begin(), stiffness.end());
  M.setFromTriplets(capacities.begin(), capacities.end());
  const Vec u = Vec::Zero(n);
  PhiStepper heat{u, linear(K), forward_euler, capacity(M)};
  CHECK(preflight(heat, u, 0.1).whole.rate == Approx(12).epsilon(1e-3));
  CHECK(preflight(heat, u, 0.1).whole.rate >= 12 * (1 - 1e-4));
  CHECK(preflight(heat, u, 0.1).stable_dt == Approx(0.999 / 6).epsilon(1e-3));
}

TEST_CASE("nothing is stepped and no count changes") {
  auto y = chain_state(12);
  const auto before = y;
  PhiStepper stepper{y, ChainForce{3}, trapezoidal};
  check_nothing_stepped(stepper, y);
  Halving halving{PhiStepper{before, ChainForce{3}, velocity_verlet}, 3};
  CHECK(preflight(halving, before, 0.1).whole.frequency ==
        Approx(2 * std::sqrt(3) * std::cos(std::numbers::pi / 24)).epsilon(1e-6));
  struct Around {  // a user's own stepper around a stepper
    decltype(halving)& inside;
    [[nodiscard]] auto& stepper() const { return inside.stepper(); }
  } around{halving};
  CHECK(preflight(around, before, 0.1).whole.frequency == preflight(halving, before, 0.1).whole.frequency);
}

TEST_CASE("the text holds the numbers") {
  const auto y = chain_state(20);
  PhiStepper stepper{y, spring_network<1>(chain(20, 400)) + LinearDrag{0.5}, velocity_verlet};
  std::ostringstream out;
  out << preflight(stepper, y, 0.06);
  for (const char* piece : {"preflight: unstable", "stable to 0.0501", "omega = 39.9", "damping = 0.5", "term 0",
                            "<- stiffest", "recommended", "velocity_verlet", "fixed("})
    CHECK_THAT(out.str(), contains(piece));
}
