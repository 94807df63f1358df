#pragma once

// Balls, contacts and events of few types: each type of force, of event, of handler is a run that is compiled anew.

#include <phistep/phistep.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <vector>

#include "convergence/observed_order.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;

namespace {

using One = Eigen::Matrix<double, 1, 1>;
using Ball = Motion<One>;
using OfBall = std::function<double(const Ball&)>;
using OfOne = std::function<double(const One&)>;
[[maybe_unused]] const OfBall height = [](const Ball& y) { return y.r(0); };
[[maybe_unused]] const shared_force::OfState<One> weight = [](const One&) -> One { return One{-9.81}; };
[[maybe_unused]] const shared_force::OfState<One> decay = [](const One& x) -> One { return -x; };

/// A ball that falls on the ground bounces with a share e of its speed.
struct Bounce {
  double e;
  void operator()(double, Ball& ball) const { ball.v *= -e; }
};
[[maybe_unused]] auto bouncing(double e) { return event(height, {.direction = Direction::falling}, Bounce{e}); }

/// The times of all bounces of a ball that falls from 1 m, by fixed steps or others.
[[maybe_unused]] void check_bounces(const RunReport& report, const std::vector<double>& times, double e) {
  const double drop = std::sqrt(2 / 9.81), zeno = drop * (1 + e) / (1 - e);
  CHECK(report.outcome == Outcome::events_accumulate);
  CHECK(std::abs(report.t - zeno) <= 1e-10);
  CHECK(times.size() > 200);
  double exact = drop, flight = 2 * drop;
  for (const double t : times) {
    REQUIRE(std::abs(t - exact) <= 1e-12);
    exact += flight *= e;
  }
}
[[maybe_unused]] void check_falling_ball(auto scheme, const auto& control) {
  const double e = 0.9;
  Ball y{One{1}, One{0}};
  PhiStepper stepper{y, weight, scheme};
  auto bounce = bouncing(e);
  const auto report = integrate(stepper, y, {0, 100}, control, bounce);
  check_bounces(report, bounce.times(), e);
}

/// Overlap r and its rate v of two spheres with m_eff v' = −k r − c v, from touching at v = 1 m/s.
struct Dashpot {
  static constexpr double mass = 0.5, k = 1e5, c = 20, rate = c / (2 * mass);
  static double frequency() { return std::sqrt(k / mass - rate * rate); }
  // r = exp(−γt) sin(ω_d t)/ω_d: separated at half a period; F = 0 where k r + c v = 0, tan(ω_d t) = −2γω_d/(ω_d²−γ²).
  static double separation_time() { return std::numbers::pi / frequency(); }
  static double separation_speed() { return std::exp(-rate * separation_time()); }
  static double zero_force_time() {
    const double w = frequency();
    return (std::numbers::pi - std::atan2(2 * rate * w, w * w - rate * rate)) / w;
  }
  static double zero_force_speed() {
    const double t = zero_force_time(), w = frequency();
    return -std::exp(-rate * t) * (std::cos(w * t) - rate / w * std::sin(w * t));
  }
  static One force(const One& r, const One& v) { return One{-k * r(0) - c * v(0)}; }
};

struct Collision {
  double t, restitution;
  Outcome outcome;
};
/// In n steps a contact, ended by g.
template <class Scheme>
Collision collide(Scheme scheme, int n, const OfBall& g) {
  Ball y{One{0}, One{1}};
  PhiStepper stepper{y, shared_force::OfMotion<One>{Dashpot::force}, scheme, mass(Dashpot::mass)};
  auto over = event(g, {.direction = Direction::falling, .terminal = true});
  const double dt = Dashpot::separation_time() / n;
  const auto report = integrate(stepper, y, {0, 1}, fixed(dt), over);
  return {report.t, -y.v(0), report.outcome};
}
[[maybe_unused]] const OfBall separated = height;
[[maybe_unused]] const OfBall no_force = [](const Ball& y) { return Dashpot::k * y.r(0) + Dashpot::c * y.v(0); };

/// In `n` steps a contact, ended by g.
using Collide = std::function<Collision(int n, const OfBall& g)>;
[[maybe_unused]] void check_orders(const Collide& run) {
  for (const bool at_zero_force : {false, true}) {
    const double t = at_zero_force ? Dashpot::zero_force_time() : Dashpot::separation_time();
    const double e = at_zero_force ? Dashpot::zero_force_speed() : Dashpot::separation_speed();
    std::vector<Collision> runs;
    for (const int n : {37, 74, 148, 296}) runs.push_back(run(n, at_zero_force ? no_force : separated));
    std::array<double, 4> of_time, of_speed;
    for (std::size_t i = 0; i < 4; ++i) {
      REQUIRE(runs[i].outcome == Outcome::stopped_by_event);
      of_time[i] = std::abs(runs[i].t - t);
      of_speed[i] = std::abs(runs[i].restitution - e);
    }
    CAPTURE(at_zero_force);
    convergence::check_order(of_time, 2);
    convergence::check_order(of_speed, 2);
  }
}
[[maybe_unused]] void check_fine(const Collide& run) {
  CHECK(std::abs(run(10000, separated).restitution - Dashpot::separation_speed()) <= 1e-8);
  CHECK(std::abs(run(10000, no_force).restitution - Dashpot::zero_force_speed()) <= 1e-8);
}
[[maybe_unused]] Collide by(auto scheme) {
  return [scheme](int n, const OfBall& g) { return collide(scheme, n, g); };
}

/// When y' = −y from 1 reaches a value: y = 1/2 at log 2.
double reached(const auto& control, double t1, double wanted) {
  One y{1};
  PhiStepper stepper{y, decay, trapezoidal};
  auto level = event(OfOne{[wanted](const One& x) { return x(0) - wanted; }}, {.terminal = true});
  const auto report = integrate(stepper, y, {0, t1}, control, level);
  CHECK(report.outcome == Outcome::stopped_by_event);
  CHECK(y(0) == Approx(wanted).epsilon(1e-14));
  return report.t;
}

}  // namespace
