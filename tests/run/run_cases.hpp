#pragma once

// What run.test.cpp and its full half share.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "contract/states.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

namespace run_cases {

using namespace phistep;
using problems::distance;
using Vec = Eigen::Vector2d;
using Moving = Motion<Vec>;
using Flow = problems::ForcedFlow<>;
using Swing = problems::ForcedMotion<>;

inline const auto decay = [](const Vec& y) -> Vec { return Vec(-y[0], -2 * y[1]); };
inline Vec decayed(double t) { return {std::exp(-t), std::exp(-2 * t)}; }

inline void for_each_scheme(auto&& f) {
  f("backward_euler", backward_euler), f("phi(0.7)", phi(0.7)), f("trapezoidal", trapezoidal), f("midpoint", midpoint);
  f("tr_bdf2", tr_bdf2), f("forward_euler", forward_euler), f("rannacher", rannacher);
}

/// Random times between −2 and 3, some of them next to each other, and points of the grid −1.5 + 0.1 k or next to them.
inline std::vector<double> some_times() {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(-2, 3);
  std::vector<double> times(300);
  for (double& t : times) t = any(random);
  for (int k = 0; k < 20; ++k) times.push_back(times[static_cast<std::size_t>(k)] * (1 + 1e-15 * k));
  for (int k = 1; k < 40; ++k) times.push_back(-1.5 + 0.1 * k);  // grid points, or next to them
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}
/// Those of them that a run meets, in order.
inline std::vector<double> met_of(const std::vector<double>& times, double t0, double t1) {
  std::vector<double> met;
  for (const double t : times)
    if (t >= std::min(t0, t1) && t <= std::max(t0, t1)) met.push_back(t);
  if (t1 < t0) std::reverse(met.begin(), met.end());
  return met;
}

/// Times a rounding, and some 1e-11, apart, from 0 to 2.
inline std::vector<double> close_times() {
  std::vector<double> times;
  for (int k = 1; k < 10; ++k)
    for (double t = 0.2 * k, n = 0; n < 3; ++n, t = std::nextafter(t, 3)) times.push_back(t);
  for (int k = 0; k < 10; ++k) times.push_back(0.1 + 0.2 * k), times.push_back(0.1 + 0.2 * k + 1e-11);
  return times;
}

inline const std::vector<double> stops_between{0.25, 0.30000000000000001, 0.77};
/// @param seen  by a run of fixed(0.1) from 0 to 1 with these stops
inline void check_stops_between(const RunReport& report, const std::vector<double>& seen) {
  REQUIRE(report);
  CHECK(report.statistics.steps == 12);  // 0.3 and 3·0.1 are one
  REQUIRE(seen.size() == 13);
  CHECK(seen[2] == 2 * 0.1);
  CHECK(seen[3] == 0.25);
  CHECK(seen[4] == 0.3);
  CHECK(seen[5] == 4 * 0.1);
  CHECK(seen[8] == 7 * 0.1);
  CHECK(seen[9] == 0.77);
  CHECK(seen[10] == 8 * 0.1);
}

/// A motion whose vectors grow and shrink while the run goes on.
void check_growing(auto scheme, const auto& fall) {
  using V = Eigen::VectorXd;
  using Grown = Motion<V>;
  using Edit = std::function<void(double, Grown&)>;
  Grown y{V::Ones(2), V::Zero(2)};
  PhiStepper stepper{y, fall, scheme};
  const auto go = [&](Grown& state, const tolerance& control, std::vector<double> times, Edit edit) {
    return integrate(stepper, state, {0, 2}, control, at_times(std::move(times), std::move(edit)));
  };
  const RunReport report = go(y, tolerance{.rtol = 1e-4}, {0.5, 1.0}, [](double t, Grown& s) {
    const Index n = s.r.size() + (t < 0.7 ? 40 : -41);
    s.r = V::Constant(n, std::cos(t)), s.v = V::Constant(n, -std::sin(t));
  });
  REQUIRE(report);
  REQUIRE(y.r.size() == 1);
  CHECK(y.r[0] == Approx(std::cos(2.0)).margin(1e-3));
  // A tolerance for each component is then no longer one.
  Grown z{V::Ones(2), V::Zero(2)};
  const RunReport refused = go(z, tolerance{.rtol = 1e-4, .atol = V(V::Constant(4, 1e-6))}, {0.5},
                               [](double, Grown& s) { s.r = s.v = V::Ones(3); });
  CHECK(refused.outcome == Outcome::invalid_tolerance);
  CHECK(refused.message().find("another size") != std::string::npos);
  CHECK(refused.t == 0.5);
}

/// @param stepper  of decay, from 0 on
template <class Stepper>
void check_observers_that_stop(Stepper& stepper, Vec& y) {
  std::string order;
  double last = 0;
  const RunReport report = integrate(
      stepper, y, {0, 1}, tolerance{.rtol = 1e-3}, [&](double, const Vec&) { order += 'a'; },
      [&](const CompletedStep<Vec>& step) {
        order += 'b';
        CHECK(step.t0() == last);
        last = step.t1();
        CHECK(step.end() == y);
        return order.size() < 9;
      },
      [&](double, const Vec&) { order += 'c'; });
  CHECK(order == "acbacbacb");  // those of whole steps first: the others may edit
  CHECK(report.outcome == Outcome::stopped_by_observer);
  CHECK(report.t == last);
}

}  // namespace run_cases
