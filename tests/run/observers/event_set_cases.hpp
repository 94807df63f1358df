#pragma once

// What event_set.test.cpp and its full half share.

#include <phistep/base/state/motion.hpp>
#include <phistep/run/inside/dense_output.hpp>
#include <phistep/run/observers/event_set.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "support/catch.hpp"

namespace event_set_cases {

using namespace phistep;

template <class Scalar>
using One = Eigen::Matrix<Scalar, 1, 1>;
template <class Scalar>
using Ball = Motion<One<Scalar>>;

/// The loop of event_set.hpp around a flow y(t + dt) = flow(t, dt, y), y' = slope(t, y).
template <State S, class Flow, class Slope, class... Events>
struct Loop {
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  Flow flow;
  Slope slope;
  EventSet<S, Events...> events;
  int steps = 0, resteps = 0;
  Outcome outcome = Outcome::success;

  Loop(const S&, Flow f, Slope s, Events&... e) : flow{f}, slope{s}, events{e...} {}

  /// From t to t1; returns when it ended.
  Scalar run(S& y, Scalar t, Scalar t1, Scalar dt) {
    steps = resteps = 0;
    outcome = events.begin(t, y);
    return outcome == Outcome::success ? go_on(y, t, t1, dt) : t;
  }
  Scalar go_on(S& y, Scalar t, Scalar t1, Scalar dt) {
    DenseOutput<S> dense;
    while (outcome == Outcome::success && t != t1) {
      const bool last = !(std::abs(t1 - t) > std::abs(dt));
      const Scalar h = last ? t1 - t : dt, next = last ? t1 : t + dt;
      Plain start;
      copy_blocks<S>(start, y);
      Plain end = flow(t, h, start);
      const auto slopes = [&](Plain& s0, Plain& s1) {
        s0 = slope(t, start);
        s1 = slope(next, end);
      };
      dense.begin(t, h, next, start, end, DenseOutput<S>::Slopes::of(slopes));
      ++steps;
      const auto found = events.find(CompletedStep<S>(t, h, next, start, end, dense));
      outcome = found.outcome;
      if (outcome != Outcome::success) return t;
      if (!found) {
        copy_blocks<S>(y, end);
        t = next;
        continue;
      }
      const auto hit = events.refine(found, [&](Scalar to) {
        end = flow(t, to - t, start);
        return &end;
      });
      resteps += hit.resteps;
      copy_blocks<S>(y, end);
      t = hit.t;
      outcome = std::isfinite(hit.g) ? events.happen(found, t, y) : Outcome::non_finite_event;
    }
    return t;
  }
};

/// Free fall with g = 1, exactly.
template <class Scalar>
const auto fall = [](Scalar, Scalar dt, const Ball<Scalar>& y) {
  return Ball<Scalar>{One<Scalar>{y.r(0) + dt * (y.v(0) - dt / 2)}, One<Scalar>{y.v(0) - dt}};
};
template <class Scalar>
const auto falling = [](Scalar, const Ball<Scalar>& y) {
  return Ball<Scalar>{y.v, One<Scalar>{Scalar(-1)}};
};
inline const auto height = [](const auto& y) { return y.r(0); };

template <class Scalar>
Ball<Scalar> ball(double r, double v) {
  return {One<Scalar>{static_cast<Scalar>(r)}, One<Scalar>{static_cast<Scalar>(v)}};
}

/// x' = 1, so that events are functions of time.
inline const auto clock_flow = [](double, double dt, const One<double>& y) { return One<double>{y(0) + dt}; };
inline const auto clock_slope = [](double, const One<double>&) { return One<double>{1.0}; };

template <class Scalar>
void check_bounces() {
  // The formula and the times kept are double.
  const double u = std::max<double>(std::numeric_limits<Scalar>::epsilon(), 0x1p-52) / 2;
  for (const double e : {0.9, 0.5, 0.3, 0.1, 0.01})
    for (const double dt : {0.01, 0.37, 5.0, 1e4}) {
      CAPTURE(e, dt);
      const double drop = std::sqrt(2.0), zeno = drop * (1 + e) / (1 - e);
      auto bounce = event(height, {.direction = Direction::falling},
                          [e](Scalar, Ball<Scalar>& y) { y.v *= -static_cast<Scalar>(e); });
      Ball<Scalar> y = ball<Scalar>(1, 0);
      Loop loop(y, fall<Scalar>, falling<Scalar>, bounce);
      const auto t = static_cast<double>(loop.run(y, 0, 2e4, static_cast<Scalar>(dt)));
      CHECK(loop.outcome == Outcome::events_accumulate);
      // What is left is a geometric series from the first flight that isn't sought any more: 64 probes.
      const double unseen = 64 * 64 * u * zeno;
      CHECK(std::abs(t - zeno) <= unseen / (1 - e) / e + 1e-6 * zeno * (sizeof(Scalar) == 4));
      CHECK(std::abs(static_cast<double>(y.r(0))) <= 64 * u * zeno);
      double at = drop, flight = 2 * drop, k = 1;
      for (const double bounced : bounce.times()) {
        // Each root is known to 16 roundings of t; at the next bounce they count 1/e times, because the ball leaves
        // slowly what it entered fast. Every step before rounds r and v, four roundings in t.
        const double rounding = k * 16 * (2 + 1 / e) + 4 * (at / dt + k);
        REQUIRE(std::abs(bounced - at) <= rounding * u * at);
        flight *= e;
        at += flight;
        ++k;
      }
      CHECK(loop.resteps <= 2 * static_cast<int>(bounce.times().size()));
    }
}

}  // namespace event_set_cases
