#pragma once

// Runs of the heated points: what both halves of acceptance/assignment need.

#include <phistep/phistep.hpp>

#include <cmath>

#include "convergence/observed_order.hpp"
#include "problems/heated_points.hpp"
#include "problems/march.hpp"
#include "problems/show_digits.hpp"
#include "support/catch.hpp"

using problems::HeatedPoints;

namespace {

constexpr double end = 1;

HeatedPoints::State solve(auto scheme, int n) {
  const auto theta = HeatedPoints::start();
  phistep::PhiStepper stepper{theta, HeatedPoints{}, scheme, phistep::capacity(HeatedPoints::rho * HeatedPoints::C)};
  return problems::march(stepper, theta, 0.0, end, n);
}

void check_order(auto scheme, double order, int n) {
  convergence::check_order(
      convergence::errors(
          n, [&](int steps) { return problems::distance(solve(scheme, steps), HeatedPoints::exact(end)); }),
      order);
}

}  // namespace
