#pragma once

// What the quick and the full half of run/stepper/resize share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace resize_cases {
/// Throws when told to, with its force half written.
struct Interrupted {
  static constexpr bool uses_velocity = false, uses_time = false;
  const bool* fail;
  void add(double, const auto& y, auto& out) const {
    out.force[0] -= 2 * y.r[0];
    if (*fail) throw std::runtime_error("force");
    for (Eigen::Index i = 1; i < y.r.size(); ++i) out.force[i] -= 2 * y.r[i];
  }
};

/// The one force that the quick half solves for: a stepper of dynamic vectors takes seconds to compile.
struct Elastic {
  double k;
  Dynamic operator()(const Dynamic& r) const { return -k * r; }
};

void check_interrupted(auto scheme) {
  bool fail = false;
  SecondOrder<Dynamic> a, b;
  PhiStepper stepper{a.state, Interrupted{&fail}, scheme};
  PhiStepper never{b.state, Interrupted{&fail}, scheme};
  for (int n = 0; n < 10; ++n) {
    fail = true;
    CHECK_THROWS_AS(stepper.step(a.state, 0.1 * n, 0.2), std::runtime_error);
    fail = false;
    REQUIRE(stepper.step(a.state, 0.1 * n, 0.1));
    REQUIRE(never.step(b.state, 0.1 * n, 0.1));
    CHECK(distance(numbers(a.state), numbers(b.state)) <= 1e-13);
  }
}

void check_parameter(auto scheme) {
  SecondOrder<Dynamic> a;
  PhiStepper stepper{a.state, Elastic{1}, scheme};
  REQUIRE(stepper.step(a.state, 0, 0.1));
  SecondOrder<Dynamic> b;
  b.state = a.state;
  stepper.force().k = 50;
  PhiStepper fresh{b.state, Elastic{50}, scheme};
  REQUIRE(stepper.step(a.state, 0.1, 0.1));
  REQUIRE(fresh.step(b.state, 0.1, 0.1));
  CHECK(distance(numbers(a.state), numbers(b.state)) <= 1e-14);
}

void check_reset(const auto& force, auto scheme, double tolerance) {
  SecondOrder<Dynamic> a, b;
  PhiStepper one{a.state, force, scheme}, two{b.state, force, scheme};
  for (int n = 0; n < 20; ++n) {
    two.reset();
    REQUIRE((one.step(a.state, 0, 0.1) && two.step(b.state, 0, 0.1)));
  }
  CHECK(distance(numbers(a.state), numbers(b.state)) <= tolerance);
}

void check_sizes(const auto& force, auto scheme, const auto&... masses) {
  Motion<Dynamic> y{Dynamic::Ones(2), Dynamic::Zero(2)};
  PhiStepper stepper{y, force, scheme, masses...};
  for (const Eigen::Index size : {2, 5, 5, 1, 8, 2}) {
    y.r = Dynamic::LinSpaced(size, 1, 2), y.v = Dynamic::Zero(size);
    auto z = y;
    PhiStepper fresh{z, force, scheme, masses...};
    REQUIRE(stepper.step(y, 0, 0.1));
    REQUIRE(fresh.step(z, 0, 0.1));
    CHECK(distance(numbers(y), numbers(z)) <= 1e-14);
  }
}

void check_mass_that_fits_no_more(auto scheme) {
  Dynamic y = Dynamic::Ones(2);
  PhiStepper stepper{y, Pull{}, scheme, mass(Eigen::Vector2d(1, 2))};
  REQUIRE(stepper.step(y, 0, 0.1));
  y = Dynamic::Ones(3);
  for (int k = 0; k < 2; ++k) CHECK_THROWS_AS(stepper.step(y, 0, 0.1), std::invalid_argument);
  CHECK(y == Dynamic::Ones(3));
  y = Dynamic::Ones(2);
  CHECK(stepper.step(y, 0, 0.1));
}

template <class State>
void check_copies(const State& start, const State& other, const auto& force, auto scheme) {
  const auto run = [&](bool disturb) {
    State y = start;
    PhiStepper stepper{y, force, scheme};
    for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(y, 0, 0.01));
    auto copy = std::make_unique<decltype(stepper)>(stepper);
    if (disturb) {
      State z = other;
      REQUIRE(copy->step(z, 0, 0.3));
      copy.reset();
    }
    const Statistics before = stepper.statistics();
    for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(y, 0, 0.01));
    return std::pair{y, stepper.statistics() - before};
  };
  const auto disturbed = run(true), alone = run(false);
  CHECK(same_bits(numbers(disturbed.first), numbers(alone.first)));
  CHECK(disturbed.second == alone.second);
}

}  // namespace resize_cases
