// Sleeping: what truly rests falls asleep, and what only turns moves on. A body whose pushes don't balance passes through a
// time at which it is slow: at the top of its flight, at a pendulum's end, in the first moments on a slope. With Sleeping
// its path must be the one that it has without, but for what a speed below SleepOptions::speed may add up to.
#include <phistep/particles.hpp>
#include <phistep/particles/sleep/sleeping.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/contact_chance.hpp"
#include "support/battery.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace contact_scenes;

#if PHISTEP_STRESS
constexpr int members = 200;
#elif PHISTEP_FULL
constexpr int members = 32;
#endif

namespace {

using Vec = Eigen::Vector3d;
using Balls = Particles<double, 3>;
constexpr double R = 0.01, m = 0.01, g = 9.81;

/// How far from the exact path, and how much faster or slower than there, over a whole run.
struct Misses {
  double place = 0, speed = 0;
  bool finished = false;
};
/// @param exact  of t: place and velocity of particle 0
Misses compare(auto force, Balls y, SleepOptions options, double t1, double dt, auto exact) {
  Sleeping stepper{PhiStepper{y, force, symplectic_euler}, options};
  Misses misses;
  const auto look = [&](double t, const Balls& now) {
    const auto [r, v] = exact(t);
    misses.place = std::max(misses.place, (now.r.col(0) - r).norm());
    misses.speed = std::max(misses.speed, (now.v.col(0) - v).norm());
  };
  misses.finished = static_cast<bool>(integrate(stepper, y, {0.0, t1}, fixed(dt), look));
  return misses;
}

/// A body that is slower than `speed` for q times the steps that it takes to fall asleep.
void turning(battery::Tally& tally, Chance& chance, int n) {
  const double q = chance.ratio(0.5, 100);
  SleepOptions options{
      .speed = chance.ratio(1e-4, 1), .steps = 40 + 20 * chance.one_of(6), .every = 5 + 5 * chance.one_of(5)};
  Balls y{Vec{0, 0, 0}};
  y.set_mass(m).set_radius(R);
  const double v_s = options.speed;
  // t1: twenty times as long as it takes the push to make it as fast as v_s; a body that hangs is then off by ten times
  // what a speed of v_s would bring.
  Misses b;
  double t1 = 0;
  const char* name = "";
  // What passes from 0 to v_s in so long under a, and symplectic Euler's own error, a dt/2 in the speed.
  const auto step_for = [&](double a) { return v_s / a / (q * options.steps); };
  switch (n % 4) {
    case 0: {  // at the top of its flight
      name = "top of a flight";
      const double v0 = v_s * chance.between(0, 8), dt = step_for(g);
      y.v(2, 0) = v0, y.v(0, 0) = v_s * chance.between(0, 0.5);
      const Vec v = y.v.col(0);
      t1 = (v0 + 20 * v_s) / g;
      b = compare(Gravity{Vec{0, 0, -g}}, y, options, t1, dt, [&](double t) {
        return std::pair{Vec(v * t - Vec(0, 0, g * t * t / 2)), Vec(v - Vec(0, 0, g * t))};
      });
      break;
    }
    case 1: {  // a slope without friction; gravity is along it but for one part in so many
      name = "slope";
      const double alpha = chance.ratio(1e-3, 0.5), a = g * std::sin(alpha), k = 1e4;
      const Vec up{std::sin(alpha), 0, std::cos(alpha)}, down{std::cos(alpha), 0, -std::sin(alpha)};
      y.r.col(0) = (R - m * g * std::cos(alpha) / k) * up;
      const Vec r0 = y.r.col(0);
      // Steps short enough for the contact; so q follows from the slope.
      const double dt = std::min(step_for(a), M_PI * std::sqrt(m / k) / 20);
      t1 = std::min(20 * v_s / a, 4e5 * dt);
      const Walls floor{Hooke{.stiffness = k, .restitution = 0.5}, Plane<3>{Vec::Zero(), up}};
      b = compare(Gravity{Vec{0, 0, -g}} + floor, y, options, t1, dt, [&](double t) {
        return std::pair{Vec(r0 + a * t * t / 2 * down), Vec(a * t * down)};
      });
      break;
    }
    case 2: {  // a mass on a spring, at its turning points: v_s is so much of its largest speed
      name = "mass on a spring";
      const double share = chance.ratio(0.002, 0.1), omega = chance.ratio(1, 100), A = v_s / (share * omega);
      const double dt = std::min(step_for(A * omega * omega), 0.01 / omega);
      y.r(0, 0) = A;
      const double keep = omega;
      t1 = std::min(10 / omega, 1e5 * dt);
      b = compare(ExternalField{[keep](const Vec& r) -> Vec { return -m * keep * keep * r; }}, y, options, t1, dt,
                  [&](double t) {
                    return std::pair{Vec(A * std::cos(omega * t), 0, 0), Vec(-A * omega * std::sin(omega * t), 0, 0)};
                  });
      break;
    }
    default: {  // a push that is small, from rest
      name = "small push";
      const double a = chance.ratio(1e-4, 10), dt = step_for(a);
      const Vec along = chance.direction();
      t1 = 20 * v_s / a;
      b = compare(UniformForce{Vec(m * a * along)}, y, options, t1, dt, [&](double t) {
        return std::pair{Vec(a * t * t / 2 * along), Vec(a * t * along)};
      });
    }
  }
  tally.count(b.finished && b.place <= 2.5 * v_s * t1 && b.speed <= 2.5 * v_s,
              text(n, " ", name, ", slow for ", q, " times the steps of sleep: off by ", b.place, " m, ", b.speed / v_s,
                   " times the speed, in ", t1, " s"));
}

/// One that sleeps under a small push is woken: it then has the velocity that the push gave it meanwhile.
void returned(battery::Tally& tally, Chance& chance, int n) {
  const double a = chance.ratio(1e-3, 10);
  SleepOptions options{.speed = chance.ratio(1e-4, 1), .steps = 50, .every = 10};
  const double v_s = options.speed, dt = v_s / a / (50 * chance.ratio(8, 100));
  Balls y{Vec{0, 0, 0}};
  y.set_mass(m).set_radius(R);
  const Vec along = chance.direction();
  Sleeping stepper{PhiStepper{y, UniformForce{Vec(m * a * along)}, symplectic_euler}, options};
  double t = 0, worst = 0;
  bool finished = true;
  for (int wakes = 0; wakes < 4; ++wakes) {
    const double until = t + v_s / a * chance.between(0.5, 4);
    for (; t < until; t += dt) finished = finished && stepper.step(y, t, dt);
    stepper.reset();
    finished = finished && stepper.step(y, t, dt), t += dt;
    worst = std::max(worst, (y.v.col(0) - a * t * along).norm() / v_s);
  }
  tally.count(finished && worst <= 1, text(n, ": awake, it misses ", worst, " times SleepOptions::speed"));
}

/// Bodies that come to rest, and are to sleep at the end.
void resting(battery::Tally& tally, Chance& chance, int n) {
  const double k = chance.ratio(1e3, 1e5), dt = M_PI * std::sqrt(m / k) / 20;
  const Hooke law{.stiffness = k, .restitution = chance.between(0.1, 0.5), .friction = 0.6};
  const SleepOptions options{.speed = chance.ratio(3e-4, 3e-3), .steps = 50, .every = 10};
  const auto settles = [&](auto force, Balls y, const char* name) {
    Sleeping stepper{PhiStepper{y, force, symplectic_euler}, options};
    double t = 0;
    bool finished = true;
    for (int s = 0; s < 30000 && stepper.report().asleep < y.size() - (y.body().is_still(0) ? 1 : 0); ++s, t += dt)
      finished = finished && stepper.step(y, t, dt);
    const auto before = stepper.report();
    const Eigen::Matrix3Xd r = y.r;
    // From time to time a sleeper is looked at again, which takes some steps.
    for (int s = 0; s < 2000; ++s, t += dt) finished = finished && stepper.step(y, t, dt);
    const double share = static_cast<double>(stepper.report().skipped - before.skipped) / 2000;
    tally.count(finished && before.asleep > 0 && share > 0.5 && (y.r - r).norm() < 1e-2 * R,
                text(n, " ", name, ": ", before.asleep, " asleep of ", y.size(), ", later ", share, ", moved by ",
                     (y.r - r).norm()));
  };
  const auto weight = Gravity{Vec{0, 0, -g}};
  const Plane<3> floor{Vec::Zero(), Vec::UnitZ()};
  switch (n % 4) {
    case 0: {
      Balls y{Vec{0, 0, R * chance.between(1, 1.5)}};
      y.set_mass(m).set_radius(R);
      return settles(weight + Walls{law, floor}, y, "dropped on a floor");
    }
    case 1: {
      const double a = chance.between(0.3, 0.7);
      Balls y{Vec{0, 0, R / std::cos(a) + R * chance.between(0, 0.2)}};
      y.set_mass(m).set_radius(R);
      return settles(weight + Walls{law, Plane<3>{Vec::Zero(), {std::sin(a), 0, std::cos(a)}},
                                    Plane<3>{Vec::Zero(), {-std::sin(a), 0, std::cos(a)}}},
                     y, "in a groove");
    }
    case 2: {
      const double a = chance.between(0.05, 0.4);
      Balls y{Vec(R * Vec(std::sin(a), 0, std::cos(a)))};
      y.set_mass(m).set_radius(R);
      return settles(weight + Walls{law, Plane<3>{Vec::Zero(), {std::sin(a), 0, std::cos(a)}}}, y, "held by friction");
    }
    default: {
      const double length = 0.1, stiff = chance.ratio(10, 1000);
      Balls y{Eigen::Matrix<double, 3, 2>{{0, 0}, {0, 0}, {0, -length}}};
      y.set_mass(m).set_radius(R).set_still({1, 0});
      return settles(weight + spring_network<3>({{0, 1, stiff, length}}, SpringDamping{std::sqrt(stiff * m)}), y,
                     "hung on a damped spring");
    }
  }
}

battery::Tally run(const char* name, std::uint64_t seed, auto one) {
  battery::Tally tally{.name = name};
  Chance chance{seed};
  for (int n = 0; n < members; ++n) one(tally, chance, n);
  return tally;
}

}  // namespace

TEST_CASE("what rests falls asleep and stays") { battery::at_most(0, run("bodies at rest", 7, resting)); }
TEST_CASE("what turns with Sleeping moves on") {
  battery::at_most(0, run("bodies that are slow but don't rest", 5, turning));
}
TEST_CASE("a sleeper that is woken has what its push gave it") {
  battery::at_most(0, run("what a sleeper is given back", 6, returned));
}
