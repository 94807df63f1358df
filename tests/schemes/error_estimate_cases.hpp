#pragma once

// What the quick and the full half of schemes/error_estimate share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "contract/states.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using problems::distance;
using states::numbers;
using Vec = Eigen::Vector2d;
using Flow = problems::ForcedFlow<>;
using Swing = problems::ForcedMotion<>;

namespace error_estimate_cases {

inline const auto yes = [](const auto&...) { return true; };

/// The solution through (t, y) at t + dt, by 64 steps of the classical Runge-Kutta method: (1/64)⁴ of what a step of order
/// 4 would leave, nothing beside estimates of order 3.
template <class S>
S solution(const std::function<bool(double, const S&, S&)>& slope, const S& y0, double t, double dt) {
  const int n = 64;
  const double h = dt / n;
  const auto at = [&](double time, const S& y) {
    S out = y;
    if (!slope(time, y, out)) throw std::runtime_error("no slope");
    return out;
  };
  const auto plus = [](const S& y, double by, const S& k) {
    S sum = y;
    for_each_block([by](auto, auto& to, const auto& from) { to += by * from; }, Blocks<S>::all(sum), Blocks<S>::all(k));
    return sum;
  };
  S y = y0;
  for (int i = 0; i < n; ++i, t += h) {
    const S a = at(t, y), b = at(t + h / 2, plus(y, h / 2, a)), c = at(t + h / 2, plus(y, h / 2, b)),
            d = at(t + h, plus(y, h, c));
    y = plus(plus(plus(plus(y, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
  }
  return y;
}

/// ‖estimate − error‖/‖error‖ of each block
template <class S>
std::vector<double> misjudgement(const S& estimate, const S& y, const S& exact) {
  std::vector<double> off;
  for_each_block([&](auto, const auto& e, const auto& got,
                     const auto& truth) { off.push_back((e - (got - truth)).norm() / (got - truth).norm()); },
                 Blocks<S>::all(estimate), Blocks<S>::all(y), Blocks<S>::all(exact));
  return off;
}

/// ‖estimate − error‖/‖error‖ of the last of five steps of different lengths, all of about h; blocks apart. That step
/// starts from (t, last) whatever h.
template <class S>
std::vector<double> misjudged(auto make, const S& last, double t, double h) {
  S y = last;
  auto stepper = make(y), slopes = make(y);
  const std::function<bool(double, const S&, S&)> slope = [&slopes](double at, const S& from, S& out) {
    return static_cast<bool>(slopes.slope(at, from, out));
  };
  y = solution(slope, last, t, -4 * h);
  t -= 4 * h;
  using Stepper = decltype(stepper);
  StepDoubling<Stepper, S> doubling;
  doubling.resize(y);
  Trace<S> trace;
  trace.resize(y);
  std::vector<double> off;
  for (const double factor : {1.0, 0.8, 1.3, 0.9, 1.2}) {
    const double dt = factor * h;
    const S before = y, exact = solution(slope, before, t, dt);
    StepReport done;
    bool direct = false;
    if constexpr (facts_of<Stepper>.traces) direct = stepper.estimates(trace);
    if constexpr (facts_of<Stepper>.traces)
      if (direct) done = stepper.attempt(y, t, dt, Origin::unknown, trace, yes);
    if (!direct) done = doubling.attempt(stepper, y, t, dt, Origin::unknown, trace, yes);
    if (!done || !trace.has_error) throw std::runtime_error(done.message());
    off = misjudgement(trace.error, y, exact);
    trace.advance();
    t += dt;
  }
  return off;
}

/// The estimate is the error up to a factor 1 + O(h): half the step, half as far from it.
inline void check_judgement(const std::vector<double>& coarse, const std::vector<double>& fine, double first) {
  REQUIRE_FALSE(coarse.empty());
  for (std::size_t k = 0; k < coarse.size(); ++k) {
    CAPTURE(k, coarse[k], fine[k]);
    CHECK(coarse[k] <= first);
    CHECK(fine[k] <= std::max(coarse[k] / 2, 0.01));  // 1/4 but for the sum with O(h²)
  }
}
template <class S>
void check(auto make, const S& start, double h, double first = 0.5) {
  check_judgement(misjudged(make, start, 0.3, h), misjudged(make, start, 0.3, h / 4), first);
}

/// What makes a stepper of the forced flow by `scheme`.
auto flow(auto scheme) {
  return [scheme](const Vec& y) { return PhiStepper{y, Flow{}, scheme, capacity(Flow::capacity)}; };
}

void check_slopes(auto make, auto y) {
  using S = decltype(y);
  auto stepper = make(y), other = make(y);
  Trace<S> trace;
  trace.resize(y);
  double t = 0.3;
  for (int n = 0; n < 4; ++n) {
    S start = y, end = y;
    REQUIRE(other.slope(t, y, start));
    REQUIRE(stepper.attempt(y, t, 0.01, Origin::unknown, trace, yes));
    t += 0.01;
    REQUIRE(other.slope(t, y, end));
    REQUIRE(trace.has_slopes);
    // By the scheme's relations: exact but for Newton's rounding over φΔt.
    CHECK(distance(trace.start, start) <= 1e-11);
    CHECK(distance(trace.end, end) <= 1e-11);
    CHECK(trace.dt == 0.01);
    trace.advance();
    CHECK(trace.knows_start);
    CHECK(trace.dt_before == 0.01);
  }
}

void check_stiff_at_rest(auto scheme) {
  // y0' = −λ (y0 − cos t) is at its limit long since; y1' = −y1. An explicit difference of slopes, Δt λ·noise, would.
  const auto steps = [scheme](double lambda) {
    const auto force = [lambda](const Vec& y, double t) -> Vec { return Vec(-lambda * (y[0] - std::cos(t)), -y[1]); };
    Vec y(1, 1);
    PhiStepper stepper{y, force, scheme};
    const RunReport report = integrate(stepper, y, {0, 3}, tolerance{.rtol = 1e-4});
    REQUIRE(report);
    CHECK(y[1] == Approx(std::exp(-3)).epsilon(2e-3));
    if (lambda > 1) CHECK(y[0] == Approx(std::cos(3) + std::sin(3) / lambda).epsilon(2e-3));  // … + O(λ⁻²)
    return report.statistics.steps;
  };
  const auto mild = steps(1), stiff = steps(1e3), very = steps(1e7);
  CAPTURE(mild, stiff, very);
  CHECK(stiff <= 2 * mild);
  CHECK(very <= 2 * mild);
}

template <class V, class Matrix>
void check_affine_counts(V y, const Matrix& K) {
  // Trapezoidal, affine: Ψ at the start from the last slope, one solve, one more for the filter. The affine path looks at
  // its residual (one call) before each solve, and after solves 1, 2, 3, 4, 6, 8 … with its matrix.
  PhiStepper stepper{y, linear(K), tr_bdf2};
  Trace<V> trace;
  trace.resize(y);
  trace.newton_target = 0.03;
  trace.weight.setConstant(1e6);
  Statistics before;
  const auto spent = [&](bool accept, double t) {
    before = stepper.statistics();
    const StepReport done =
        stepper.attempt(y, t, 0.01, Origin::unknown, trace, [accept](const auto&...) { return accept; });
    CHECK(static_cast<bool>(done) == accept);
    if (accept) trace.advance();
    return stepper.statistics() - before;
  };
  const Statistics first = spent(true, 0);
  CHECK(first.steps == 1);
  CHECK(first.factorizations == 1);
  CHECK(first.solves == 3);           // two resolves and the filter
  CHECK(first.force_calls == 1 + 4);  // y', each resolve's residual, and a look after solves 1 and 2
  const Statistics second = spent(true, 0.01);
  CHECK(second.factorizations == 0);
  CHECK(second.solves == 3);
  CHECK(second.force_calls == 2 + 2);  // y' is known; looks after solves 3 and 4
  const Statistics rejected = spent(false, 0.02);
  CHECK(rejected.steps == 0);
  CHECK(rejected.rejections == 1);
  CHECK(rejected.failed_steps == 0);
  CHECK(rejected.factorizations == 0);
  CHECK(rejected.force_calls == 3);
  CHECK(rejected.solves == 3);
}

/// Calls of the force in ten steps by an explicit scheme, each accepted at the second try.
std::int64_t calls_of_ten(auto scheme, const auto& spring) {
  Motion<Vec> y{Vec(1, 0), Vec(0, 1)};
  PhiStepper stepper{y, spring, scheme};
  Trace<Motion<Vec>> trace;
  trace.resize(y);
  REQUIRE(stepper.attempt(y, 0, 0.01, Origin::unknown, trace, yes));
  trace.advance();
  const Statistics start = stepper.statistics();
  for (int n = 0; n < 10; ++n) {
    CHECK_FALSE(stepper.attempt(y, 0, 0.02, Origin::unknown, trace, [](const auto&...) { return false; }));
    REQUIRE(stepper.attempt(y, 0, 0.01, Origin::unknown, trace, yes));
    trace.advance();
  }
  const Statistics s = stepper.statistics() - start;
  CHECK(s.steps == 10);
  CHECK(s.rejections == 10);
  CHECK(s.solves + s.jacobians + s.iterations == 0);
  return s.force_calls;
}

}  // namespace error_estimate_cases
