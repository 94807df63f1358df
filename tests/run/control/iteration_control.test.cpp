// Steps as long as K_d corrections allow.
#include <phistep/phistep.hpp>
#include <phistep/run/control/iteration_control.hpp>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support/catch.hpp"
#if PHISTEP_QUICK
#include "support/shared_force.hpp"
#endif

namespace iteration_cases {

using namespace phistep;
using One = Eigen::Matrix<double, 1, 1>;
using Swing = Motion<One>;
using Two = Eigen::Vector2d;

inline SolveRecord contracting(int corrections, double q) {
  SolveRecord history;
  for (int k = 0; k < corrections; ++k) history.add(0.3 * std::pow(q, k));
  return history;
}

/// m r'' = −ω² r, by plain iteration.
struct Pull {
  double omega_squared;
  auto operator()(const auto& r) const { return (-omega_squared * r).eval(); }
};

/// How far from `desired` the iterations of the last 100 of 200 steps get, for ω² = 400.
int off_desired(const auto& force, auto scheme, double first, int desired, double tol) {
  Motion<Two> y{Two(1, 0), Two(0, 20)};  // round in a circle: no phase at which everything passes through zero
  PhiStepper stepper{y, force, scheme, fixed_point({.rtol = tol, .depth = 0})};
  Run run{stepper, y, {0.0, 1e6}, iteration_control{.first_step = first, .desired = desired}};
  std::vector<int> iterations;
  for (int n = 0; n < 200; ++n) {
    REQUIRE(run.advance());
    iterations.push_back(stepper.last_solve().iterations);
  }
  int worst = 0;
  for (std::size_t n = 100; n < 200; ++n) worst = std::max(worst, std::abs(iterations[n] - desired));
  return worst;
}

template <class State>
void check_smaller_of(const State& start, const auto& pull, auto scheme) {
  // Slow and weak, then stiff: error rules the first, iterations the second.
  const auto run = [&](double omega_squared, const auto& control) {
    State y = start;
    PhiStepper stepper{y, pull(omega_squared), scheme, fixed_point({.depth = 0})};
    const RunReport report = integrate(stepper, y, {0, 5}, control);
    CHECK(report);
    return report;
  };
  const tolerance tight{.rtol = 1e-5}, loose{.rtol = 0.3, .atol = 10.0};
  const iteration_control few{.first_step = 1e-3, .desired = 3}, many{.first_step = 1e-3, .desired = 20};
  const RunReport by_error = run(1, smaller_of(tight, many)), alone = run(1, tight);
  CHECK(by_error.limits.most().by == LimitedBy::error);
  CHECK(by_error.statistics.steps ==
        Approx(static_cast<double>(alone.statistics.steps)).epsilon(0.2));  // the dead band
  const RunReport by_iterations = run(1, smaller_of(loose, few));
  CHECK(by_iterations.limits.most().by == LimitedBy::iterations);
  CHECK(by_iterations.statistics.steps > 2 * run(1, loose).statistics.steps);
  // Its own bounds count, too.
  CHECK(run(1, smaller_of(loose, {.first_step = 1e-3, .max_step = 0.01})).largest_dt <= 0.01);
}

template <class State>
void check_growth(State y, const auto& force) {
  PhiStepper stepper{y, force, velocity_verlet};
  const RunReport report = integrate(stepper, y, {0, 10}, iteration_control{.first_step = 1e-3, .max_step = 0.1});
  REQUIRE(report);
  CHECK(report.largest_dt <= 0.1);
  CHECK(report.limits.most().by == LimitedBy::max_step);
}

template <class State>
void check_recovery(State y, const auto& force, auto scheme) {
  PhiStepper stepper{y, force, scheme, fixed_point({.depth = 0})};
  const RunReport report = integrate(stepper, y, {0, 1}, iteration_control{.first_step = 0.5});
  REQUIRE(report);
  CHECK(report.t == 1);
  CHECK(report.statistics.failed_steps >= 1);
  CHECK(report.largest_dt < 0.02);  // φωΔt < 1
  CHECK(report.limits.most().by == LimitedBy::iterations);
  CHECK(y.r.squaredNorm() + y.v.squaredNorm() / 1e4 == Approx(1).epsilon(0.05));  // φ = ½ keeps the energy
}

}  // namespace iteration_cases

using namespace iteration_cases;

#if PHISTEP_QUICK

using Swing2 = Motion<Two>;
using Force = shared_force::OfState<Two>;

namespace {

Force pull(double omega_squared) {
  return [omega_squared](const Two& r) -> Two { return -omega_squared * r; };
}

}  // namespace

TEST_CASE("Λ is what makes a contraction q = S Δt^p take K_d corrections") {
  // ε_{K−1} = q^{K−1} ε_0 met the tolerance; with Δt' = Λ Δt, q' = Λ^p q, the same is met by K_d − 1 factors q'.
  for (const double p : {1.0, 2.0})
    for (const int K : {3, 6, 9, 15})
      for (const int desired : {4, 6, 10}) {
        const double q = 0.4;
        const double factor = iteration_factor(contracting(K, q), {.first_step = 1, .desired = desired, .order = p});
        const double wanted = std::pow(std::pow(q, (K - 1.0) / (desired - 1)) / q, 1 / p);
        CHECK(factor == Approx(std::clamp(wanted, 0.1, 2.0)).epsilon(1e-12));
        if (K == desired) CHECK(factor == Approx(1));
      }
}

TEST_CASE("with nothing to go by it grows; where corrections did not fall it shrinks; it is always a number") {
  const iteration_control wanted{.first_step = 1};
  CHECK(iteration_factor(SolveRecord{}, wanted) == 2);
  CHECK(iteration_factor(contracting(1, 0.5), wanted) == 2);
  CHECK(iteration_factor(contracting(3, 0.0), wanted) == 2);
  CHECK(iteration_factor(contracting(8, 1.0), wanted) == 0.1);
  CHECK(iteration_factor(contracting(8, 3.0), wanted) == 0.1);
  CHECK(iteration_factor(contracting(500, 0.99), wanted) < 1);  // longer than the history kept
  for (const double odd : {std::nan(""), HUGE_VAL, 0.0, 1e-320}) {
    SolveRecord history;
    history.add(0.1), history.add(odd), history.add(odd);
    const double factor = iteration_factor(history, wanted);
    CHECK(factor >= 0.1);
    CHECK(factor <= 2);
    SolveRecord worse;
    worse.add(odd), worse.add(0.1);
    CHECK(iteration_factor(worse, wanted) >= 0.1);
    CHECK(iteration_factor(worse, wanted) <= 2);
  }
  CHECK(iteration_factor(contracting(5, 0.5), {.first_step = 1, .desired = 1}) >= 0.1);
}

TEST_CASE("an oscillator settles at K_d ± 1 iterations, at every φ, from far too short and from far too long") {
  // Its contraction is φ²ω²Δt² exactly.
  for (const double first : {1e-6, 1e-2, 0.3, 50.0})
    for (const int desired : {5, 6, 8})
      for (const double tol : {0.0, 1e-6}) {
        CAPTURE(first, desired, tol);
        CHECK(off_desired(pull(400), phi(0.5), first, desired, tol) <= 1);
        CHECK(off_desired(pull(400), phi(1.0), first, desired, tol) <= 1);
      }
}

TEST_CASE("a start at which the iteration diverges recovers, and the run says what held it") {
  check_recovery(Swing2{Two(1, 0), Two(0, 0)}, pull(1e4), phi(0.5));
}

TEST_CASE("a force that no step makes converge ends the run") {
  Swing2 y{Two(1, 0), Two(0, 0)};
  int calls = 0;
  const Force wild = [&calls](const Two&) -> Two {
    ++calls;
    return Two(1e200 * std::sin(1.0 * calls * calls), 0);
  };
  PhiStepper stepper{y, wild, phi(0.5), fixed_point({.depth = 0})};
  const RunReport report = integrate(stepper, y, {0, 1}, iteration_control{.first_step = 0.1, .max_steps = 10'000});
  CHECK_FALSE(report);
  CHECK_FALSE(report.message().empty());
}

TEST_CASE("an explicit scheme has no iterations: the step grows to its bound") {
  check_growth(Swing2{Two(1, 0), Two(0, 0)}, pull(1));
}

TEST_CASE("smaller_of: neither the error nor the iterations are more than allowed") {
  check_smaller_of(Swing2{Two(1, 0), Two(0, 0)}, pull, phi(0.5));
  Swing2 y{Two(1, 0), Two(0, 0)};
  PhiStepper stepper{y, pull(1), phi(0.5), fixed_point({.depth = 0})};
  CHECK(integrate(stepper, y, {0, 5}, smaller_of(tolerance{.rtol = 1e-5}, {.max_steps = 3})).outcome ==
        Outcome::too_many_steps);
}

#elif PHISTEP_FULL
// iteration_control, every scheme.

TEST_CASE("an oscillator settles at K_d ± 1 iterations, at every φ, from far too short and from far too long") {
  // Its contraction is φ²ω²Δt² exactly.
  for (const double first : {1e-6, 1e-2, 0.3, 50.0})
    for (const int desired : {5, 6, 8})
      for (const double tol : {0.0, 1e-6}) {
        CAPTURE(first, desired, tol);
        CHECK(off_desired(Pull{400}, trapezoidal, first, desired, tol) <= 1);
        CHECK(off_desired(Pull{400}, backward_euler, first, desired, tol) <= 1);
      }
}

TEST_CASE("smaller_of: neither the error nor the iterations are more than allowed") {
  check_smaller_of(
      Swing{One(1), One(0)}, [](double omega_squared) { return Pull{omega_squared}; }, trapezoidal);
  Swing y{One(1), One(0)};
  PhiStepper stepper{y, Pull{1}, trapezoidal};
  CHECK(integrate(stepper, y, {0, 5}, smaller_of(tolerance{.rtol = 1e-5}, {.max_steps = 3})).outcome ==
        Outcome::too_many_steps);
}

TEST_CASE("an explicit scheme has no iterations: the step grows to its bound") {
  check_growth(Swing{One(1), One(0)}, Pull{1});
}

TEST_CASE("a start at which the iteration diverges recovers, and the run says what held it") {
  check_recovery(Swing{One(1), One(0)}, Pull{1e4}, trapezoidal);
}

#endif
