// What contact.test.cpp and contact.test.cpp share.
#pragma once

#include <Eigen/Geometry>

#include <phistep/io/checkpoint.hpp>
#include <phistep/particles/bodies/particles.hpp>
#include <phistep/particles/contacts/contact.hpp>
#include <phistep/phistep.hpp>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>
#include <utility>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace contact_cases {

using Grains = Particles<double, 3, Spin>;
using Smooth = Particles<double, 3>;
using Matrix = Eigen::Matrix3Xd;

template <class State = Grains>
State bodies(const Matrix& r, double m = 1, double radius = 0.5) {
  State y{r};
  y.set_mass(m).set_radius(radius);
  return y;
}

struct Collision {
  double restitution, duration;
};

/// Two bodies of mass 1 and radius ½ meet head-on, `speed` fast. The contact ends inside a step: where its overlap or,
/// unless it attracts, its force reaches 0, found from the last state before by Taylor's formula.
template <class Law>
Collision collide(const Law& law, double speed, double dt) {
  Matrix r(3, 2);
  r << -0.5, 0.5, 0, 0, 0, 0;
  auto y = bodies<Smooth>(r);
  y.v << speed / 2, -speed / 2, 0, 0, 0, 0;
  y.r(0, 1) -= 1e-12;  // so that they touch at t = 0: the dashpot acts at once
  PhiStepper stepper{y, Contact{law}, velocity_verlet};
  const auto force = [&](double overlap, double parting) {
    return Law::response(law.numbers(), overlap, parting, 2.0, 4.0).normal;
  };
  double force0 = 0;
  for (int n = 0; n < 100000; ++n) {
    const double overlap0 = 1 - (y.r(0, 1) - y.r(0, 0)), v0 = y.v(0, 1) - y.v(0, 0), before = force0;
    force0 = force(overlap0, v0);
    REQUIRE(stepper.step(y, n * dt, dt));
    const double overlap1 = 1 - (y.r(0, 1) - y.r(0, 0)), v1 = y.v(0, 1) - y.v(0, 0);
    if (law.attracts && overlap1 < 0) {
      const double a = force0 * 2;
      double tau = overlap0 / v0;
      for (int i = 0; i < 5; ++i) tau = (overlap0 - a * tau * tau / 2) / v0;
      return {(v0 + a * tau) / speed, n * dt + tau};
    }
    if (!law.attracts && v1 > 0 && force(overlap1, v1) <= 0) {
      const double slope = (force0 - before) / dt, tau = -force0 / slope;
      return {(v0 + (force0 * tau + slope * tau * tau / 2) * 2) / speed, n * dt + tau};
    }
  }
  FAIL("they stick together");
  return {};
}

/// What is left of Verlet's error of order 2 after Richardson's extrapolation.
template <class Law>
Collision extrapolated(const Law& law, double speed, double dt) {
  const Collision coarse = collide(law, speed, dt), fine = collide(law, speed, dt / 2);
  return {(4 * fine.restitution - coarse.restitution) / 3, (4 * fine.duration - coarse.duration) / 3};
}

}  // namespace contact_cases

namespace contact_cases {

inline Eigen::Vector3d angular_momentum(const Grains& y) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Index i = 0; i < y.size(); ++i) {
    const Eigen::Vector3d r = y.r.col(i), v = y.v.col(i), w = y.omega.col(i);
    sum += y.mass()[i] * r.cross(v) + 0.4 * y.mass()[i] * y.radius()[i] * y.radius()[i] * w;
  }
  return sum;
}

/// Grains thrown into each other, turning, of two sizes.
inline Grains jumble(unsigned seed, int n, double spread) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  Matrix r(3, n), v(3, n), w(3, n);
  Eigen::VectorXd m(n), radius(n);
  for (int i = 0; i < n; ++i) {
    r.col(i) << spread * u(random), spread * u(random), spread * u(random);
    v.col(i) = -3 * r.col(i) + Eigen::Vector3d(u(random), u(random), u(random));
    w.col(i) << 5 * u(random), 5 * u(random), 5 * u(random);
    radius[i] = 0.4 + 0.1 * u(random);
    m[i] = 8 * radius[i] * radius[i] * radius[i];
  }
  Grains y{r};
  y.v = v, y.omega = w;
  y.set_mass(m).set_radius(radius);
  return y;
}

inline const Hooke rough{.stiffness = 1e3, .restitution = 0.7, .friction = 0.4};

template <class Law>
void check_momentum(const Law& law) {
  // Kick, then drift: the forces on a pair are opposite, and their torques make up for their moment, at the positions that
  // both see. A few roundings a step of numbers of order 100: 1e-11 over 400 steps.
  Grains y = jumble(3, 12, 1.2);
  const Eigen::Vector3d p0 = y.v * y.mass(), l0 = angular_momentum(y);
  PhiStepper stepper{y, Contact{law}, symplectic_euler};
  std::int64_t contacts = 0;
  for (int n = 0; n < 400; ++n) {
    REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
    contacts += stepper.force().statistics().touching;
  }
  CHECK(contacts > 300);
  CHECK((y.v * y.mass() - p0).norm() < 1e-11);
  CHECK((angular_momentum(y) - l0).norm() < 1e-11);
}

/// A run whose every step is tried in vain by `fail` first, and done three times as long and taken back, is one without.
void check_no_trace(const auto& force, const auto& fail) {
  const auto run = [&](bool disturbed) {
    Grains y = jumble(9, 6, 0.8);
    PhiStepper stepper{y, force, symplectic_euler};
    for (int n = 0; n < 40; ++n) {
      if (disturbed) {
        fail(stepper, y, n * 1e-3);
        const auto kept = y;
        const auto checkpoint = stepper.checkpoint();
        REQUIRE(stepper.step(y, n * 1e-3, 3e-3));
        y = kept;
        stepper.restore(checkpoint);
      }
      REQUIRE(stepper.step(y, n * 1e-3, 1e-3));
    }
    return y;
  };
  const Grains a = run(false), b = run(true);
  CHECK((a.r == b.r && a.v == b.v && a.omega == b.omega));
}

/// Three in a row, none of which touch.
inline Matrix three() { return Matrix{{0, 2, 4}, {0, 0, 0}, {0, 0, 0}}; }
StepReport one_step(auto& y, const auto& contact) {
  PhiStepper stepper{y, contact, symplectic_euler};
  return stepper.step(y, 0, 1e-3);
}

}  // namespace contact_cases
