#pragma once

// What the quick and the full tests of the stepper's contract share: forces of one type each, splits, watched steps.

#include <phistep/phistep.hpp>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>

#include "contract/states.hpp"
#include "contract/stepper_battery.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

namespace states {

inline const ForceOf<SecondOrder<Dynamic>> dynamic_pull = Pull{};
inline const shared_force::OfMotionAndTime<Dynamic> damped_pull = DampedPull{};

struct Halve {
  auto operator()(auto stepper) const { return Halving{std::move(stepper), 3}; }
};

// Named schemes and their formulas: v' = −w r, one step from (r, v), against the source's two lines solved by hand.

struct StepByHand {
  static constexpr double h = 0.3, r = 0.7, v = -0.4, w = 1.5;
};

/// @param one_step  of a scheme: (r⁺, v⁺)
inline void check_formulas(auto one_step) {
  constexpr double h = StepByHand::h, r = StepByHand::r, v = StepByHand::v, w = StepByHand::w;
  const auto formula = [&](double pf, double pd) {
    // v⁺ = v − h w (pf r⁺ + (1−pf) r),  r⁺ = r + h (pd v⁺ + (1−pd) v)
    const double v1 = (v - h * w * (r + pf * h * (1 - pd) * v)) / (1 + h * h * w * pf * pd);
    return Eigen::Vector2d(r + h * (pd * v1 + (1 - pd) * v), v1);
  };
  const auto compare = [](const Eigen::Vector2d& stepped, const Eigen::Vector2d& expected) {
    CHECK((stepped - expected).norm() <= 1e-15);
  };
  const auto check = [&](auto scheme, const Eigen::Vector2d& expected) { compare(one_step(scheme), expected); };
  check(forward_euler, formula(0, 0));
  check(trapezoidal, formula(0.5, 0.5));
  check(backward_euler, formula(1, 1));
  check(midpoint, formula(0.5, 0.5));
  check(symplectic_euler, formula(0, 1));
  check(symplectic_euler_adjoint, formula(1, 0));
  check(phi(0.7), formula(0.7, 0.7));
  check(phi(0.2, 0.9), formula(0.2, 0.9));
  check(phi_stage(0.3), formula(0.3, 0.3));
  // (I − aA)(r⁺, v⁺) = b with A(r, v) = (v, −w r)
  const auto resolved = [&](double a, const Eigen::Vector2d& b) {
    const double v1 = (b[1] - a * w * b[0]) / (1 + a * a * w);
    return Eigen::Vector2d(b[0] + a * v1, v1);
  };
  const auto advanced = [&](double a, const Eigen::Vector2d& y) {
    return Eigen::Vector2d(y[0] + a * y[1], y[1] - a * w * y[0]);
  };
  const Eigen::Vector2d y{r, v};
  const double g = 2 - std::sqrt(2.0);
  const Eigen::Vector2d Y = resolved(g / 2 * h, advanced(g / 2 * h, y));
  check(tr_bdf2, resolved((1 - g) / (2 - g) * h, Y / (g * (2 - g)) - y * (1 - g) * (1 - g) / (g * (2 - g))));
  check(rannacher, resolved(h / 2, resolved(h / 2, y)));
  // Newmark's (1) and (2) with a = k = −w r at the start.
  const double r0 = r + h * v - h * h * (0.5 - 0.3) * w * r, v0 = v - h * (1 - 0.6) * w * r;  // without a⁺
  const double a1 = -w * r0 / (1 + 0.3 * h * h * w);
  check(newmark(0.3, 0.6), Eigen::Vector2d(r0 + h * h * 0.3 * a1, v0 + h * 0.6 * a1));
  check(hht(-0.2), formula(0.5, 0.5));  // a start
  check(rannacher(0), resolved(h / 2, advanced(h / 2, y)));
  const double half = v - h / 2 * w * r, r1 = r + h * half;
  check(velocity_verlet, Eigen::Vector2d(r1, half - h / 2 * w * r1));
}

// Steps that are watched.

inline void check_watched(Subject& watched, Subject& plain) {
  CAPTURE(watched.name);
  // By rounding alone: r and v are of order one, and slopes by (y⁺ − b)/φΔt are off by 1e-16/0.01, times Δt.
  const auto agree = [&] { return distance(watched.numbers(), plain.numbers()) <= 1e-13; };
  double t = 0;
  const auto both = [&](double dt) {
    const Eigen::VectorXd before = watched.numbers();
    const Statistics counted = watched.statistics();
    for (const double longer : {3 * dt, dt}) {
      CHECK(watched.attempt(t, longer, false).outcome() == Outcome::error_too_large);
      CHECK(same_bits(watched.numbers(), before));
    }
    CHECK(watched.statistics().rejections == counted.rejections + 2);
    CHECK(watched.statistics().steps == counted.steps);
    CHECK(watched.statistics().failed_steps == counted.failed_steps);
    REQUIRE(watched.attempt(t, dt, true));
    REQUIRE(plain.step(t, dt));
    CHECK(agree());
    t += dt;
  };
  for (const double dt : {0.01, 0.02, 0.015, -0.01, 0.03}) both(dt);

  // An edit, told to the trace.
  watched.edit(), plain.edit();
  watched.forget();
  for (const double dt : {0.02, 0.01}) both(dt);

  // Plain steps in between: the trace is to forget, the stepper notices by itself.
  REQUIRE(watched.step(t, 0.01));
  REQUIRE(plain.step(t, 0.01));
  CHECK(agree());
  t += 0.01;
  watched.forget();
  for (const double dt : {0.01, 0.02}) both(dt);

  // What can't be stepped is refused as by step().
  const Eigen::VectorXd before = watched.numbers();
  CHECK(watched.attempt(t, 0, true).outcome() == Outcome::invalid_step);
  CHECK(watched.attempt(1.0, 1e-17, true).outcome() == Outcome::step_too_small);
  CHECK(same_bits(watched.numbers(), before));
}

template <class Case>
void check_watched(auto scheme, const auto& force, const char* name = "") {
  const auto watched = subject_of<Case, true>(force, scheme), plain = subject_of<Case, true>(force, scheme);
  watched->name = name;
  if (watched->traces()) check_watched(*watched, *plain);
}

/// A force that fails at one of its calls.
struct Fatal {
  Trouble mood = Trouble::none;
  int calls = 0, call = 0;
  Dynamic operator()(const Dynamic& y) {
    Dynamic f = Pull{}(y);
    if (++calls == call && mood == Trouble::exception) throw std::runtime_error("moody");
    if (calls == call) component(f, 2) = std::nan("");
    return f;
  }
};

/// Trouble at every single force call of a watched step: nothing moves, and the next step is as if nothing had been.
inline void check_watched_trouble(Subject& watched, Subject& good, Fatal& fatal) {
  CAPTURE(watched.name);
  for (int n = 0; n < 2; ++n) {
    REQUIRE(watched.attempt(0.05 * n, 0.05, true));
    REQUIRE(good.attempt(0.05 * n, 0.05, true));
  }
  double t = 0.1;
  for (const Trouble trouble : {Trouble::nan, Trouble::exception})
    for (int k = 1; k <= 8; ++k) {
      CAPTURE(k);
      const Eigen::VectorXd before = watched.numbers();
      fatal = {.mood = trouble, .calls = 0, .call = k};
      bool done = false;
      try {
        done = static_cast<bool>(watched.attempt(t, 0.05, false));
      } catch (const std::runtime_error&) {
      }
      CHECK_FALSE(done);
      CHECK(same_bits(watched.numbers(), before));
      fatal.call = 0;
      REQUIRE(watched.attempt(t, 0.05, true));
      REQUIRE(good.attempt(t, 0.05, true));
      CHECK(distance(watched.numbers(), good.numbers()) <= 1e-13);
      t += 0.05;
    }
}

template <class Case>
void check_watched_trouble(auto scheme, const char* name = "") {
  Fatal fatal;
  const auto watched = subject_of<Case, true>(ForceOf<Case>(std::ref(fatal)), scheme);
  const auto good = subject_of<Case, true>(ForceOf<Case>(Pull{}), scheme);
  watched->name = name;
  if (watched->traces()) check_watched_trouble(*watched, *good, fatal);
}

/// By phi on `force`, by Verlet on a pull.
void check_undone(const auto& force) {
  // endpoint φ(h), then endpoint 1−φ(−h)
  SecondOrder<Dynamic> c;
  const Eigen::VectorXd before = numbers(c.state);
  PhiStepper forth{c.state, force, phi(0.3)};
  PhiStepper back{c.state, force, phi(0.7)};
  REQUIRE(forth.step(c.state, 0, 0.1));
  CHECK(distance(numbers(c.state), before) > 0.01);
  REQUIRE(back.step(c.state, 0.1, -0.1));
  CHECK(distance(numbers(c.state), before) <= 1e-14);

  PhiStepper verlet{c.state, dynamic_pull, velocity_verlet};
  REQUIRE(verlet.step(c.state, 0, 0.1));
  REQUIRE(verlet.step(c.state, 0.1, -0.1));
  CHECK(distance(numbers(c.state), before) <= 1e-14);
}

}  // namespace states
