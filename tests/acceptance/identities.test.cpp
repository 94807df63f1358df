// Relations that hold for one step of any problem: the source's formulas, the splitting into forward and backward
// Euler, adjoints, Newmark; and the clock. The named schemes: identities.full.cpp.

#include "acceptance/identities_cases.hpp"

TEST_CASE("a step satisfies the source's equations (1.12) and (1.13)") {
  for (const double phi : phis) {
    const double residual = worst_residual(by(phistep::phi(phi)), source(phi));
    CAPTURE(phi, residual);
    CHECK(residual <= residual_bound);
  }
}

TEST_CASE("derivation: what the source's equations (1.2) to (1.13) leave out is of the order that they state") {
  // A motion known at all times: r = sin(1.3 t + 0.4), v = r', a = v' = Ψ/m, and b = a'.
  const auto at = [](double t, int derivative) {
    return std::pow(1.3, derivative) * std::sin(1.3 * t + 0.4 + derivative * std::acos(0.0));
  };
  const auto order = [](auto&& left_out) { return std::log2(left_out(0.02) / left_out(0.01)); };
  const double t = 0.3;
  for (const double phi : {0.0, 0.25, 0.5, 0.8, 1.0}) {
    CAPTURE(phi);
    const double more = phi == 0.5 ? 1 : 0;  // of the hat in Ô: one order is gained at φ = ½
    for (const int k : {0, 1}) {             // r in (1.7) to (1.9), v in (1.2) to (1.4)
      const auto taylor = [&](double dt, double to) {
        const double from = t + phi * dt, by = to - from;
        return at(from, k) + by * at(from, k + 1) + by * by / 2 * at(from, k + 2) - at(to, k);
      };
      if (phi < 1)
        CHECK(order([&](double dt) { return taylor(dt, t + dt); }) == Approx(3).margin(0.05));        // (1.2), (1.7)
      if (phi > 0) CHECK(order([&](double dt) { return taylor(dt, t); }) == Approx(3).margin(0.05));  // (1.3), (1.8)
      const auto slope = [&](double dt) { return (at(t + dt, k) - at(t, k)) / dt - at(t + phi * dt, k + 1); };
      CHECK(order(slope) == Approx(1 + more).margin(0.05));                                      // (1.4), (1.9)
      CHECK(order([&](double dt) { return dt * slope(dt); }) == Approx(2 + more).margin(0.05));  // (1.5)
      CHECK(slope(1e-3) == Approx((0.5 - phi) * 1e-3 * at(t, k + 2)).margin(1e-6));              // its first term
    }
    const auto weighted = [&](double dt, int k) { return phi * at(t + dt, k) + (1 - phi) * at(t, k); };
    if (phi > 0 && phi < 1)
      for (const int k : {1, 2})  // (1.6) of v, (1.12) of Ψ
        CHECK(order([&](double dt) { return weighted(dt, k) - at(t + phi * dt, k); }) == Approx(2).margin(0.05));
    const auto moved = [&](double dt, double by) { return at(t + dt, 0) - at(t, 0) - by; };
    CHECK(order([&](double dt) { return moved(dt, dt * weighted(dt, 1)); }) ==
          Approx(2 + more).margin(0.05));  // (1.10)
    CHECK(order([&](double dt) { return moved(dt, dt * at(t, 1) + phi * dt * dt * at(t + phi * dt, 2)); }) ==
          Approx(2 + more).margin(0.05));  // (1.11)
    CHECK(order([&](double dt) { return moved(dt, dt * at(t, 1) + phi * dt * dt * weighted(dt, 2)); }) ==
          Approx(2 + more).margin(0.05));  // (1.13)
  }
}

TEST_CASE("a stage step evaluates the force once, at t + phi h on the chord") {
  for (const double phi : phis) {
    const double residual = worst_residual(by(phistep::phi_stage(phi)), stage(phi));
    CAPTURE(phi, residual);
    CHECK(residual <= residual_bound);
  }
}

TEST_CASE("a pair weights the force by phi_force and the drift by phi_drift") {
  for (const double phi_force : phis)
    for (const double phi_drift : phis) {
      const double residual = worst_residual(by(phistep::phi(phi_force, phi_drift)), pair(phi_force, phi_drift));
      CAPTURE(phi_force, phi_drift, residual);
      CHECK(residual <= residual_bound);
    }
}

TEST_CASE("velocity Verlet solves its last half-kick for the new velocity") {
  const auto verlet = [](const State& y, const State& next, double t) {
    const Vec middle = y.v + h / 2 / mass * force(y.r, y.v, t);
    return largest(next.r - y.r - h * middle, next.v - middle - h / 2 / mass * force(next.r, next.v, t + h));
  };
  CHECK(worst_residual(by(phistep::velocity_verlet), verlet) <= residual_bound);
}

TEST_CASE("twins: endpoint is backward Euler after forward Euler, stage the other way round") {
  for (const double phi : {0.25, 0.5, 0.7}) {
    const double before = (1 - phi) * h, after = phi * h;
    const double endpoint = twin_defect(by(phistep::phi(phi)), by(phistep::phi(0)), before, by(phistep::phi(1)), after);
    const double stage =
        twin_defect(by(phistep::phi_stage(phi)), by(phistep::phi(1)), after, by(phistep::phi(0)), before);
    CAPTURE(phi, endpoint, stage);
    CHECK(endpoint <= 1e-14);
    CHECK(stage <= 1e-14);
    // The two forms are not the same scheme.
    CHECK(twin_defect(by(phistep::phi(phi)), by(phistep::phi(1)), after, by(phistep::phi(0)), before) > 1e-5);
  }
}

TEST_CASE("adjoint: a step with phi over h and one with 1 - phi over -h lead back") {
  for (const double phi : phis) {
    CAPTURE(phi);
    CHECK(return_defect(by(phistep::phi(phi)), by(phistep::phi(1 - phi))) <= 1e-13);
    CHECK(return_defect(by(phistep::phi_stage(phi)), by(phistep::phi_stage(1 - phi))) <= 1e-13);
  }
  CHECK(return_defect(by(phistep::velocity_verlet), by(phistep::velocity_verlet)) <= 1e-13);
  CHECK(return_defect(by(phistep::phi(0.7)), by(phistep::phi(0.7))) > 1e-4);  // only its adjoint undoes a step
}

namespace {

/// Newmark's method as the textbooks write it, for m r'' = Ψ(r).
struct Newmark {
  double beta, gamma;
  Vec a;  // the acceleration that goes with the state

  void step(State& y, const HardeningSpring& spring) {
    const Vec r = y.r + h * y.v + h * h * (0.5 - beta) * a;  // without β h² a⁺
    Vec next = a;
    for (int k = 0; k < 20; ++k) {
      const Vec x = r + beta * h * h * next;
      const Eigen::Matrix2d matrix = mass * Eigen::Matrix2d::Identity() - beta * h * h * spring.jacobian(x);
      const Vec correction = matrix.inverse() * (spring(x) - mass * next);
      next += correction;
    }
    y.v += h * ((1 - gamma) * a + gamma * next);
    y.r = r + beta * h * h * next;
    a = next;
  }
};

}  // namespace

TEST_CASE("Newmark: a pair is Newmark's method with beta = phi_f phi_d, gamma = phi_f + phi_d - 1/2") {
  // Exact for C = 0, once the velocity is shifted: v_N = v + h (φ_d − ½) a.
  const HardeningSpring spring;
  for (const double phi_force : {0.25, 0.5, 0.7, 1.0})
    for (const double phi_drift : {0.0, 0.25, 0.5, 0.7, 1.0}) {
      State y = HardeningSpring::start();
      phistep::PhiStepper stepper{y, spring, phistep::phi(phi_force, phi_drift), phistep::mass(mass)};
      const double shift = h * (phi_drift - 0.5);
      Newmark newmark{phi_force * phi_drift, phi_force + phi_drift - 0.5, spring(y.r) / mass};
      State z{y.r, y.v + shift * newmark.a};
      double worst = 0;
      for (int n = 0; n < 50; ++n) {
        problems::step(stepper, y, h * n, h);
        newmark.step(z, spring);
        worst = std::max(worst, largest(z.r - y.r, z.v - shift * newmark.a - y.v));
      }
      CAPTURE(phi_force, phi_drift, worst);
      CHECK(worst <= 1e-13);
    }
}

TEST_CASE("time: a run is at t0 + n h exactly, in the observer and in the force") {
  // dt has 43 digits, so that n·dt is exact and t0 + n·dt the same number with and without fused multiply-add; beside
  // t0 it has too many for a running sum.
  const double t0 = 1000.3, dt = std::ldexp(std::round(std::ldexp(0.1, 46)), -46);
  constexpr int n = 1000;
  std::vector<double> seen, asked;
  using One = Eigen::Matrix<double, 1, 1>;
  One y{1};
  const shared_force::OfStateAndTime<One> rate = [&asked](const One& x, double t) -> One {
    asked.push_back(t);
    return -x;
  };
  phistep::PhiStepper stepper{y, rate, phistep::forward_euler};
  const double t1 = t0 + n * dt;
  REQUIRE(
      phistep::integrate(stepper, y, {t0, t1}, phistep::fixed(dt), [&](double t, const One&) { seen.push_back(t); }));
  REQUIRE(seen.size() == n + 1);
  REQUIRE(asked.size() == n);
  int wrong = 0;
  for (int k = 0; k <= n; ++k) wrong += seen[static_cast<std::size_t>(k)] != t0 + k * dt;
  for (int k = 0; k < n; ++k) wrong += asked[static_cast<std::size_t>(k)] != t0 + k * dt;
  CHECK(wrong == 0);
  CHECK(seen.back() == t1);

  double sum = t0;
  for (int k = 0; k < n; ++k) sum += dt;
  CHECK(sum != t1);
}
