#pragma once

// One step and what has to hold for it: what both halves of acceptance/identities need.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
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
