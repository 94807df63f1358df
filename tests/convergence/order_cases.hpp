#pragma once

// Errors of n steps: what both halves of convergence/order need.

#include <phistep/phistep.hpp>

#include <cmath>

#include "convergence/observed_order.hpp"
#include "problems/dahlquist.hpp"
#include "problems/forced.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "problems/show_digits.hpp"
#include "support/catch.hpp"

using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::march;

namespace {

constexpr double end = 2;

double flow_error(auto scheme, int n) {
  using Problem = problems::ForcedFlow<>;
  const auto y = Problem::exact(0);
  phistep::PhiStepper stepper{y, Problem{}, scheme, phistep::capacity(Problem::capacity)};
  return distance(march(stepper, y, 0.0, end, n), Problem::exact(end));
}

double motion_error(auto scheme, int n) {
  using Problem = problems::ForcedMotion<>;
  const auto y = Problem::exact(0);
  phistep::PhiStepper stepper{y, Problem{}, scheme, phistep::mass(Problem::mass)};
  return distance(march(stepper, y, 0.0, end, n), Problem::exact(end));
}

double kepler_error(auto scheme, int n) {
  const problems::Kepler kepler{0.3};
  phistep::PhiStepper stepper{kepler.start(), kepler, scheme};
  return distance(march(stepper, kepler.start(), 0.0, end, n), kepler.exact(end));
}

void check_flow(auto scheme, double order, int n) {
  check_order(errors(n, [&](int steps) { return flow_error(scheme, steps); }), order);
}
void check_motion(auto scheme, double order, int n) {
  check_order(errors(n, [&](int steps) { return motion_error(scheme, steps); }), order);
}

// The next term of the error is O(h) beside the leading one for order 1, O(h²) for order 2: at these n it moves the
// observed order by less than 0.05.
constexpr int fine = 400, coarse = 50;

}  // namespace
