#pragma once

// What the quick and the full half of schemes/error_estimate share.
#include <phistep/phistep.hpp>

#include <cmath>
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

}  // namespace error_estimate_cases
