#pragma once

// What the quick and the full half of schemes/rosenbrock share.
#include <phistep/particles.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

#include "convergence/observed_order.hpp"
#include "problems/dahlquist.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::march;

namespace rosenbrock_cases {

/// Accepts every try, or none: one type, so that attempt is compiled once for each stepper.
struct Verdict {
  bool accepts;
  bool operator()(const auto&...) const { return accepts; }
};

// Errors at t = 2 of a flow and of a damped motion, nonlinear, non-autonomous, with a mass, in n steps.
double flow_error(auto scheme, int n) {
  using Flow = problems::ForcedFlow<>;
  const auto y = Flow::exact(0);
  PhiStepper stepper{y, Flow{}, scheme, capacity(Flow::capacity)};
  return distance(march(stepper, y, 0.0, 2.0, n), Flow::exact(2));
}
double motion_error(auto scheme, int n) {
  using Moved = problems::ForcedMotion<>;
  const auto y = Moved::exact(0);
  PhiStepper stepper{y, Moved{}, scheme, mass(Moved::mass)};
  return distance(march(stepper, y, 0.0, 2.0, n), Moved::exact(2));
}

/// @param calls  of the force, a step
template <class State>
void check_cost(const State& start, const auto& force, auto scheme, int calls) {
  State y = start;
  PhiStepper stepper{y, force, scheme};
  REQUIRE(stepper.step(y, 0.0, 1e-3));
  CHECK(stepper.statistics().force_calls == calls);
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 1);
  CHECK(stepper.statistics().solves == calls);

  Trace<State> trace;
  trace.resize(y);
  const auto before = y;
  CHECK(stepper.attempt(y, 1e-3, 1.0, Origin::unknown, trace, Verdict{false}).outcome() == Outcome::error_too_large);
  CHECK(y == before);
  const auto tried = stepper.statistics();
  REQUIRE(stepper.attempt(y, 1e-3, 1e-3, Origin::unknown, trace, Verdict{true}));
  CHECK(stepper.statistics().force_calls - tried.force_calls == calls - 1);  // Ψ and J were there
  CHECK(stepper.statistics().jacobians == tried.jacobians);
  CHECK(stepper.statistics().factorizations == tried.factorizations + 1);

  // And the step is the one of a stepper that was never refused.
  auto z = before;
  PhiStepper fresh{z, force, scheme};
  REQUIRE(fresh.step(z, 1e-3, 1e-3));
  CHECK(y == z);
  // An edit is seen.
  y = before;
  CHECK_FALSE(stepper.attempt(y, 1e-3, 1e-3, Origin::unknown, trace, Verdict{false}));
  y[0] *= 2, z = y;
  REQUIRE(stepper.step(y, 1e-3, 1e-3));
  REQUIRE(PhiStepper{z, force, scheme}.step(z, 1e-3, 1e-3));
  CHECK(y == z);
}

/// @param amplification  by a step, of z = λΔt
inline void check_l_stable(const std::function<double(double z)>& amplification) {
  CHECK(std::abs(amplification(-1e10)) <= 1e-8);
  for (double z = -1e-3; z > -1e9; z *= 3) CHECK(std::abs(amplification(z)) <= 1);
  CHECK(amplification(-0.1) == Approx(std::exp(-0.1)).epsilon(1e-6));
}

/// The largest error inside of steps that start on the solution.
double dense_error(auto scheme, int n) {
  using Flow = problems::ForcedFlow<>;
  double worst = 0;
  auto y = Flow::exact(0);
  PhiStepper stepper{y, Flow{}, scheme, capacity(Flow::capacity)};
  Trace<Flow::State> trace;
  trace.resize(y);
  trace.wants_dense = true;
  const double h = 2.0 / n;
  for (int k = 0; k < n; ++k) {
    const Flow::State from = Flow::exact(k * h);  // local: what the interpolant adds to the ends' own error
    y = from;
    if (!stepper.attempt(y, k * h, h, Origin::unknown, trace, Verdict{true})) return HUGE_VAL;
    Flow::State at;
    for (const double x : {0.2, 0.5, 0.7}) {
      stepper.interpolate(x, h, from, y, at);
      worst = std::max(worst, distance(at, Flow::exact((k + x) * h)));
    }
    stepper.interpolate(1e-300, h, from, y, at);
    if (distance(at, from) > 1e-15) return HUGE_VAL;
  }
  return worst;
}

}  // namespace rosenbrock_cases
