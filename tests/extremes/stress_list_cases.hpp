#pragma once

// What the quick and the full half of extremes/stress_list share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <utility>

#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Net = Motion<Eigen::Matrix3Xd>;

namespace stress_list_cases {

inline Vec alternating(double light, double heavy, Eigen::Index n) {
  Vec m(n);
  for (Eigen::Index i = 0; i < n; ++i) m[i] = i % 2 == 0 ? light : heavy;
  return m;
}

/// A dumbbell of 1 and 1e12 that turns and rings: momentum, implicit and explicit.
void check_dumbbell(auto scheme) {
  const Vec masses = alternating(1, 1e12, 2);
  Net y{Eigen::Matrix3Xd::Zero(3, 2), Eigen::Matrix3Xd::Zero(3, 2)};
  y.r(0, 0) = 1.1, y.v(1, 0) = 0.5, y.v(1, 1) = 1e-6;
  const Eigen::Vector3d before = y.v * masses;
  PhiStepper stepper{y, spring_network<3>({{0, 1, 100.0, 1.0}}), scheme, mass(masses)};
  int done = 0;
  for (int n = 0; n < 1000; ++n) done += stepper.step(y, 0.02 * n, 0.02) ? 1 : 0;
  CHECK(done == 1000);
  CHECK((y.v * masses - before).norm() <= 1e-13 * before.norm());
  CHECK(y.r.col(0).norm() == Approx(1.05).epsilon(0.1));
}

/// With states V of two numbers.
template <class V>
void check_without_inverse() {
  // 1 = φz, z > 0: to the last bit, and beside it.
  for (const double h : {1.0, std::nextafter(1.0, 0.0), std::nextafter(1.0, 2.0), 1 + 1e-12}) {
    CAPTURE(h);
    const auto check = [h](auto stepper) {
      V y = V::Ones(2);
      const StepReport report = stepper.step(y, 0, h);
      if (h == 1) CHECK(report.outcome() == Outcome::singular_matrix);
      if (!report) CHECK(y == V::Ones(2));
      else CHECK(std::abs(y[0] * (1 - h) - 1) <= 1e-3);  // 1 − z is known to its last bit here
    };
    const V y = V::Ones(2);
    const auto grows = Eigen::Matrix<double, V::RowsAtCompileTime, V::RowsAtCompileTime>::Identity(2, 2).eval();
    check(PhiStepper{y, linear(grows), backward_euler});
    V z = y;
    Halving halving{PhiStepper{z, linear(grows), backward_euler}, 4};
    CHECK(halving.step(z, 0, 1));
    CHECK(z[0] == 4);  // (1 − ½)⁻²
  }
}

/// y' = 1 from y = 0.
template <class V>
auto run_clock(const V& zero, double t0, double t1, const auto& control, auto&... events) {
  V y = zero;
  PhiStepper stepper{
      y, shared_force::OfStateAndTime<V>{[n = zero.size()](const V&, double) -> V { return V::Ones(n); }}, trapezoidal};
  const RunReport report = integrate(stepper, y, {t0, t1}, control, events...);
  return std::pair{report, y[0]};
}
template <class V>
void check_floor_of_time(const V& zero) {
  // At 1e16 the clock ticks in twos.
  const auto [stuck, none] = run_clock(zero, 1e16, 1e16 + 200, fixed(0.5));
  CHECK(stuck.outcome == Outcome::step_too_small);
  CHECK(none == 0);
  const auto [through, sum] = run_clock(zero, 1e16, 1e16 + 200, fixed(2));
  CHECK((through && through.t == 1e16 + 200 && through.statistics.steps == 100 && sum == 200));
  const auto [chosen, length] = run_clock(zero, 1e16, 1e16 + 200, tolerance{});
  CHECK((chosen && chosen.t == 1e16 + 200 && std::abs(length - 200) <= 2));  // its own steps are no whole ticks
  // A span of one rounding is one step, whoever chooses its length.
  const double next = std::nextafter(1.0, 2.0);
  for (const double t1 : {next, 1.0}) {
    const auto [grid, by_grid] = run_clock(zero, 1, t1, fixed(0.1));
    const auto [own, by_error] = run_clock(zero, 1, t1, tolerance{});
    CHECK((grid && own && grid.t == t1 && own.t == t1 && by_grid == t1 - 1 && by_error == t1 - 1));
  }
}

// Beside an atol, a component that is denormal is nothing; by rtol alone it is followed or the run says that it can't.
template <class V>
void check_denormal_parts(const auto& decay) {
  for (const double size : {1e-300, 1e-308, 1e-310, 1e-320, 0.0}) {
    CAPTURE(size);
    V mixed = Eigen::Vector2d(1, size), alone = V::Constant(2, size);
    PhiStepper one{mixed, decay, trapezoidal}, other{alone, decay, trapezoidal};
    REQUIRE(integrate(one, mixed, {0, 1}, tolerance{.rtol = 1e-5, .atol = 1e-8}));
    CHECK(mixed[0] == Approx(std::exp(-1.0)).epsilon(1e-4));
    CHECK(std::abs(mixed[1]) <= 1.01 * size);
    const RunReport report = integrate(other, alone, {0, 1}, tolerance{.rtol = 1e-5, .atol = 0});
    if (report) CHECK(std::abs(alone[0] - size * std::exp(-1.0)) <= 1e-4 * size + 1e-322);
    else CHECK(size < 1e-300);
    CHECK(alone.allFinite());
  }
}

}  // namespace stress_list_cases
