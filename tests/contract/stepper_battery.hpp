#pragma once

// The contract of a stepper: what it does to a state where its force misbehaves or its arguments can't work.

#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>

#include "contract/states.hpp"
#include "support/catch.hpp"

namespace states {

using namespace phistep;

enum class Trouble { none, nan, inf, exception };

/// Does as it is told.
struct Moody {
  const Trouble* mood;
  auto operator()(const auto& r) const {
    auto f = Pull{}(r);
    if (*mood == Trouble::exception) throw std::runtime_error("moody");
    if (*mood == Trouble::nan) component(f, 4) = std::nan("");
    if (*mood == Trouble::inf) component(f, 4) = -HUGE_VAL;
    return f;
  }
};

template <class Stepper>
constexpr bool is_halving = false;
template <class Stepper>
constexpr bool is_halving<Halving<Stepper>> = true;

/// `force_of` makes the force from a Moody one, `wrap` a stepper around the PhiStepper.
template <class Case>
void check_contract(auto scheme, int order, auto force_of, auto wrap) {
  using S = typename Case::State;
  Trouble mood = Trouble::none;
  Case c;
  const auto force = force_of(Moody{&mood});
  auto stepper = wrap(PhiStepper{c.state, force, scheme});
  CHECK(stepper.order() == order);
  REQUIRE(stepper.step(c.state, 0, 0.01));  // whatever may be carried, is
  const Eigen::VectorXd before = numbers(c.state);
  const auto unharmed = [&] { return same_bits(numbers(c.state), before); };

  for (const Trouble trouble : {Trouble::nan, Trouble::inf}) {
    mood = trouble;
    stepper.reset();
    const StepReport report = stepper.step(c.state, 0.01, 0.02);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK_THAT(report.message(), contains("component") && contains("t = 0.01") && contains("Try"));
    if constexpr (!is_halving<decltype(stepper)>) CHECK_THAT(report.message(), contains("dt = 0.02"));
    CHECK(report.failure().block == (Blocks<S>::drifts ? 1 : 0));
    CHECK(unharmed());
  }
  mood = Trouble::exception;
  stepper.reset();
  CHECK_THROWS_WITH(stepper.step(c.state, 0.01, 0.02), "moody");
  CHECK(unharmed());
  mood = Trouble::none;

  for (const double dt : {0.0, std::nan(""), HUGE_VAL, -HUGE_VAL})
    CHECK(stepper.step(c.state, 0.01, dt).outcome() == Outcome::invalid_step);
  for (const double t : {std::nan(""), HUGE_VAL})
    CHECK(stepper.step(c.state, t, 0.1).outcome() == Outcome::invalid_step);
  CHECK(stepper.step(c.state, 1.0, 1e-17).outcome() == Outcome::step_too_small);
  CHECK(stepper.step(c.state, 1.0, -1e-17).outcome() == Outcome::step_too_small);
  CHECK(unharmed());

  const Statistics s = stepper.statistics();
  CHECK(s.steps == 1);
  CHECK(s.failed_steps == 10);

  // After all that it steps as one that never failed, forward and backward.
  Case d;
  auto good = wrap(PhiStepper{d.state, force, scheme});
  REQUIRE(good.step(d.state, 0, 0.01));
  good.reset();  // as the other was
  for (const double dt : {0.02, -0.03}) {
    REQUIRE(stepper.step(c.state, 0.01, dt));
    REQUIRE(good.step(d.state, 0.01, dt));
    CHECK(distance(numbers(c.state), numbers(d.state)) <= 1e-14);
  }
}

template <class Case>
void check_contract(auto scheme, int order) {
  check_contract<Case>(
      scheme, order, [](Moody force) { return force; }, [](auto stepper) { return stepper; });
}

}  // namespace states
