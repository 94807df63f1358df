#pragma once

// What the quick and the full tests of the stepper's contract share: forces of one type each, splits, watched steps.

#include <phistep/phistep.hpp>

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

}  // namespace states
