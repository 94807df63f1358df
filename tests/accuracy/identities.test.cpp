// Relations that hold for one step of any problem: the source's formulas, the splitting into forward and backward
// Euler, adjoints, Newmark; and the clock. The named schemes: the full tier.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "problems/show_digits.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

using problems::HardeningSpring;

namespace {

using Vec = Eigen::Vector2d;
using State = phistep::Motion<Vec>;
constexpr double h = 0.1, mass = 1.7;
const std::vector<double> phis{0, 0.25, 0.5, 0.7, 1};

/// A nonlinear, velocity-dependent, forced and unsymmetric force. [N]
constexpr auto force = [](const Vec& r, const Vec& v, double t) -> Vec {
  return Vec{-9 * r[0] - r[0] * r[0] * r[0] + std::sin(t), -4 * r[1] + 0.3 * r[0]} - 0.4 * v - 0.1 * v.norm() * v;
};
State start() { return {Vec{1, -0.5}, Vec{0.3, 0.2}}; }

/// A scheme without its type: each is compiled once, and what is asked of it too.
using Step = std::function<void(State& y, double t, double dt)>;
Step by(auto scheme) {
  using Stepper = decltype(phistep::PhiStepper{start(), force, scheme, phistep::mass(mass)});
  const auto stepper = std::make_shared<Stepper>(start(), force, scheme, phistep::mass(mass));
  return [stepper](State& y, double t, double dt) { problems::step(*stepper, y, t, dt); };
}

/// Of a step from y at t to `next`.
using Residual = std::function<double(const State& y, const State& next, double t)>;

/// The largest component of residual(before, after, t) over 100 steps.
[[maybe_unused]] double worst_residual(const Step& step, const Residual& residual) {
  State y = start();
  double worst = 0;
  for (int n = 0; n < 100; ++n) {
    const State before = y;
    step(y, h * n, h);
    worst = std::max(worst, residual(before, y, h * n));
  }
  return worst;
}

[[maybe_unused]] double largest(const Vec& a, const Vec& b) {
  return std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff());
}

// The states are of size 1, forces of size 10 with weights h/m: a handful of roundings, 2.2e-16 each.
constexpr double residual_bound = 2e-15;

[[maybe_unused]] Residual source(double phi) {
  return [phi](const State& y, const State& next, double t) {
    const Vec blend = phi * force(next.r, next.v, t + h) + (1 - phi) * force(y.r, y.v, t);
    return largest(next.r - (y.r + y.v * h + phi * h * h / mass * blend), next.v - (y.v + h / mass * blend));
  };
}
[[maybe_unused]] Residual stage(double phi) {
  return [phi](const State& y, const State& next, double t) {
    const Vec w = next.v - y.v;
    const Vec at_stage = force(y.r + phi * h * (y.v + phi * w), y.v + phi * w, t + phi * h);
    return largest(w - h / mass * at_stage, next.r - y.r - h * (y.v + phi * w));
  };
}
[[maybe_unused]] Residual pair(double phi_force, double phi_drift) {
  return [=](const State& y, const State& next, double t) {
    const Vec blend = phi_force * force(next.r, next.v, t + h) + (1 - phi_force) * force(y.r, y.v, t);
    return largest(next.v - y.v - h / mass * blend, next.r - y.r - h * ((1 - phi_drift) * y.v + phi_drift * next.v));
  };
}

/// Two sub-steps of the given schemes and lengths against one step of `whole`, over 50 steps.
[[maybe_unused]] double twin_defect(const Step& whole, const Step& one, double length_first, const Step& two,
                                    double length_second) {
  State y = start();
  double worst = 0;
  for (int n = 0; n < 50; ++n) {
    const double t = h * n;
    State z = y;
    one(z, t, length_first);
    two(z, t + length_first, length_second);
    whole(y, t, h);
    worst = std::max(worst, largest(z.r - y.r, z.v - y.v));
  }
  return worst;
}

/// How far a step there and one back lead from where they began, over 20 steps.
[[maybe_unused]] double return_defect(const Step& there, const Step& back) {
  State y = start();
  double worst = 0;
  for (int n = 0; n < 20; ++n) {
    State z = y;
    const double t = h * n;
    there(z, t, h);
    const State next = z;
    back(z, t + h, -h);
    worst = std::max(worst, largest(z.r - y.r, z.v - y.v));
    y = next;
  }
  return worst;
}

}  // namespace

#if PHISTEP_QUICK

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
    const double endpoint =
        twin_defect(by(phistep::phi(phi)), by(phistep::phi(0.0)), before, by(phistep::phi(1)), after);
    const double stage =
        twin_defect(by(phistep::phi_stage(phi)), by(phistep::phi(1)), after, by(phistep::phi(0.0)), before);
    CAPTURE(phi, endpoint, stage);
    CHECK(endpoint <= 1e-14);
    CHECK(stage <= 1e-14);
    // The two forms are not the same scheme.
    CHECK(twin_defect(by(phistep::phi(phi)), by(phistep::phi(1)), after, by(phistep::phi(0.0)), before) > 1e-5);
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

TEST_CASE("time: a run is at t0 + n h exactly, in the observer and, but for its ends, in the force") {
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
  for (int k = 1; k < n; ++k) wrong += asked[static_cast<std::size_t>(k)] != t0 + k * dt;
  CHECK(wrong == 0);
  CHECK(asked[0] > t0);  // just behind it, as a load may jump where a run starts
  CHECK(asked[0] - t0 <= 8 * std::numeric_limits<double>::epsilon() * t0);
  CHECK(seen.back() == t1);

  double sum = t0;
  for (int k = 0; k < n; ++k) sum += dt;
  CHECK(sum != t1);
}

#elif PHISTEP_FULL
// Relations that hold for one step of any problem, by every named scheme too, of first order, and a million steps of
// the clock.

using problems::ForcedFlow;

TEST_CASE("a step satisfies the source's equations (1.12) and (1.13)") {
  for (const double phi : phis) {
    const double residual = worst_residual(by(phistep::phi(phi)), source(phi));
    CAPTURE(phi, residual);
    CHECK(residual <= residual_bound);
  }
  CHECK(worst_residual(by(phistep::forward_euler), source(0)) <= residual_bound);
  CHECK(worst_residual(by(phistep::trapezoidal), source(0.5)) <= residual_bound);
  CHECK(worst_residual(by(phistep::backward_euler), source(1)) <= residual_bound);
  CHECK(worst_residual(by(phistep::from_spectral_radius(0.25)), source(0.8)) <= residual_bound);
}

TEST_CASE("a stage step evaluates the force once, at t + phi h on the chord") {
  for (const double phi : phis) {
    const double residual = worst_residual(by(phistep::phi_stage(phi)), stage(phi));
    CAPTURE(phi, residual);
    CHECK(residual <= residual_bound);
  }
  CHECK(worst_residual(by(phistep::midpoint), stage(0.5)) <= residual_bound);
}

TEST_CASE("a pair weights the force by phi_force and the drift by phi_drift") {
  for (const double phi_force : phis)
    for (const double phi_drift : phis) {
      const double residual = worst_residual(by(phistep::phi(phi_force, phi_drift)), pair(phi_force, phi_drift));
      CAPTURE(phi_force, phi_drift, residual);
      CHECK(residual <= residual_bound);
    }
  CHECK(worst_residual(by(phistep::symplectic_euler), pair(0, 1)) <= residual_bound);
  CHECK(worst_residual(by(phistep::symplectic_euler_adjoint), pair(1, 0)) <= residual_bound);
}

TEST_CASE("twins: endpoint is backward Euler after forward Euler, stage the other way round") {
  for (const double phi : {0.25, 0.5, 0.7}) {
    const double before = (1 - phi) * h, after = phi * h;
    const double endpoint =
        twin_defect(by(phistep::phi(phi)), by(phistep::forward_euler), before, by(phistep::backward_euler), after);
    const double stage = twin_defect(by(phistep::phi_stage(phi)), by(phistep::backward_euler), after,
                                     by(phistep::forward_euler), before);
    CAPTURE(phi, endpoint, stage);
    CHECK(endpoint <= 1e-14);
    CHECK(stage <= 1e-14);
    // The two forms are not the same scheme.
    CHECK(twin_defect(by(phistep::phi(phi)), by(phistep::backward_euler), after, by(phistep::forward_euler), before) >
          1e-5);
  }
}

TEST_CASE("adjoint: a step with phi over h and one with 1 - phi over -h lead back") {
  for (const double phi : phis) {
    CAPTURE(phi);
    CHECK(return_defect(by(phistep::phi(phi)), by(phistep::phi(1 - phi))) <= 1e-13);
    CHECK(return_defect(by(phistep::phi_stage(phi)), by(phistep::phi_stage(1 - phi))) <= 1e-13);
  }
  CHECK(return_defect(by(phistep::forward_euler), by(phistep::backward_euler)) <= 1e-13);
  CHECK(return_defect(by(phistep::backward_euler), by(phistep::forward_euler)) <= 1e-13);
  CHECK(return_defect(by(phistep::trapezoidal), by(phistep::trapezoidal)) <= 1e-13);
  CHECK(return_defect(by(phistep::midpoint), by(phistep::midpoint)) <= 1e-13);
  CHECK(return_defect(by(phistep::symplectic_euler), by(phistep::symplectic_euler_adjoint)) <= 1e-13);
  CHECK(return_defect(by(phistep::symplectic_euler_adjoint), by(phistep::symplectic_euler)) <= 1e-13);
  CHECK(return_defect(by(phistep::velocity_verlet), by(phistep::velocity_verlet)) <= 1e-13);
  CHECK(return_defect(by(phistep::phi(0.7)), by(phistep::phi(0.7))) > 1e-4);  // only its adjoint undoes a step
}

TEST_CASE("a first-order step satisfies its formula with a capacity") {
  using Problem = ForcedFlow<>;
  const Problem problem;
  const auto worst = [&](auto scheme, double phi, bool stage) {
    Vec y = Problem::exact(0);
    phistep::PhiStepper stepper{y, problem, scheme, phistep::capacity(Problem::capacity)};
    double largest_residual = 0;
    for (int n = 0; n < 50; ++n) {
      const Vec before = y;
      const double t = h * n;
      problems::step(stepper, y, t, h);
      const Vec rate = stage ? problem(before + phi * (y - before), t + phi * h)
                             : Vec(phi * problem(y, t + h) + (1 - phi) * problem(before, t));
      largest_residual =
          std::max(largest_residual, (Problem::capacity * (y - before) - h * rate).cwiseAbs().maxCoeff());
    }
    return largest_residual;
  };
  for (const double phi : phis) {
    CAPTURE(phi);
    CHECK(worst(phistep::phi(phi), phi, false) <= residual_bound);
    CHECK(worst(phistep::phi_stage(phi), phi, true) <= residual_bound);
  }
}

TEST_CASE("time: a million steps of 0.1 end at 1e5, in double and in float") {
  // As a running sum, double would miss 1e5 by 1e-6, float by 958.
  const auto end_of_run = []<class T>(T dt) {
    using One = Eigen::Matrix<T, 1, 1>;
    One y{T{1}};
    phistep::PhiStepper stepper{y, [](const One& x) -> One { return T(-1e-5) * x; }, phistep::forward_euler};
    const auto report = phistep::integrate(stepper, y, {T{0}, T{100000}}, phistep::fixed(static_cast<double>(dt)));
    CHECK(report);
    CHECK(report.statistics.steps == 1000000);
    return report.t;
  };
  CHECK(end_of_run(0.1) == 100000);
  CHECK(end_of_run(0.1F) == 100000);
}

#endif
