#pragma once

// Steps of y' = λy: what both halves of acceptance/linear need.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "convergence/observed_order.hpp"
#include "problems/dahlquist.hpp"
#include "problems/march.hpp"
#include "problems/prothero_robinson.hpp"
#include "problems/show_digits.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

using problems::amplification;
using problems::Dahlquist;
using problems::march;

namespace {

constexpr double u = std::numeric_limits<double>::epsilon() / 2;  // unit round-off
const std::vector<double> phis{0, 0.25, 0.5, 0.7, 0.9, 1};

/// Calls f(scheme, φ) with both forms of one φ after the other.
template <class F>
void for_each_phi(F&& f) {
  for (const double phi : phis) {
    f(phistep::phi(phi), phi);
    f(phistep::phi_stage(phi), phi);
  }
}

/// One step of Δt = 1 from y = 1, with the given Jacobian or one by differences.
template <bool given_jacobian>
double one_step(double z, auto scheme) {
  Dahlquist::State y{1};
  if constexpr (given_jacobian) {
    phistep::PhiStepper stepper{y, Dahlquist{z}, scheme};
    problems::step(stepper, y, 0.0, 1.0);
  } else {
    const shared_force::OfState<Dahlquist::State> force = [z](const Dahlquist::State& x) -> Dahlquist::State {
      return z * x;
    };
    phistep::PhiStepper stepper{y, force, scheme};
    problems::step(stepper, y, 0.0, 1.0);
  }
  return y[0];
}

/// A hundred steps from y = 1: run() gives y.
[[maybe_unused]] void check_hundred_steps(double z, double phi, const std::function<double()>& run) {
  constexpr int n = 100;
  const long double R = amplification<long double>(z, phi);
  // Elsewhere the power itself is ill-conditioned, overflows or underflows.
  if (std::abs(R) < 0.1L || std::abs(R) > 100 || std::abs(1 - phi * z) < 0.1) return;
  const double expected = static_cast<double>(std::pow(R, n));
  const double relative = std::abs(run() / expected - 1);
  CAPTURE(z, phi, relative);
  // Each step rounds y and the increment (R−1)y, a few u of each.
  CHECK(relative <= 4 * n * u * (1 + static_cast<double>(std::abs(R - 1) / std::abs(R))));
}
double hundred_steps(double z, auto scheme) {
  Dahlquist::State y{1};
  phistep::PhiStepper stepper{y, Dahlquist{z}, scheme};
  return march(stepper, y, 0.0, 100.0, 100)[0];
}

/// One step of z with a Jacobian and one without.
[[maybe_unused]] void check_one_step(double z, double phi, double given_jacobian, double by_differences) {
  const long double R = amplification<long double>(z, phi);
  const long double condition = 1 + std::abs(phi * z) / std::abs(1 - static_cast<long double>(phi) * z);
  const double bound = static_cast<double>(4 * u * std::max(1.0L, std::abs(R)) * condition);
  const double given = static_cast<double>(std::abs(given_jacobian - R));
  const double differences = static_cast<double>(std::abs(by_differences - R));
  CAPTURE(z, phi, bound, given, differences);
  CHECK(given <= bound);
  CHECK(differences <= bound);
}

}  // namespace

namespace {

/// The largest error over the steps, and the one at t = 1.
struct Errors {
  double largest = 0, last = 0;
};
Errors prothero_robinson(auto scheme, int n) {
  const problems::ProtheroRobinson problem;
  auto y = problem.exact(0);
  phistep::PhiStepper stepper{y, problem, scheme};
  Errors errors;
  for (int k = 0; k < n; ++k) {
    problems::step(stepper, y, k * (1.0 / n), 1.0 / n);
    errors.last = std::abs(y[0] - problem.exact((k + 1.0) / n)[0]);
    errors.largest = std::max(errors.largest, errors.last);
  }
  return errors;
}

}  // namespace
