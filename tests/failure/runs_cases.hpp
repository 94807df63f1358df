// What runs.test.cpp and runs.full.cpp share.
#pragma once

#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "contract/states.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;
using problems::distance;
using Vec = Eigen::Vector2d;
using Moving = Motion<Vec>;
using Flow = problems::ForcedFlow<>;
using Swing = problems::ForcedMotion<>;

namespace runs_cases {

inline const double NaN = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

using Psi = shared_force::OfStateAndTime<Vec>;
using Look = std::function<void(double, const Vec&)>;

inline const Psi decay = [](const Vec& y, double) -> Vec { return Vec(-y[0], -2 * y[1]); };
inline Vec decayed(double t) { return {std::exp(-t), std::exp(-2 * t)}; }

/// y' = y² blows up at t = 1 where y(0) = 1.
inline const Psi square = [](const Vec& y, double) -> Vec { return y.cwiseProduct(y); };

inline void check_at_pole(const RunReport& report, const Vec& y, double shown, const Vec& last) {
  CHECK_FALSE(report);
  CHECK(report.outcome != Outcome::too_many_steps);
  CHECK(report.outcome != Outcome::invalid_step);
  CHECK(report.t == shown);
  CHECK(y == last);
  CHECK(y.allFinite());
  CHECK(report.t == Approx(1).margin(0.01));
  CHECK_FALSE(report.message().empty());
}
inline void check_before_nan(const RunReport& report, const Vec& y) {
  CHECK(report.outcome == Outcome::non_finite_force);
  CHECK_THAT(report.message(), contains("force is not finite") && contains("component 0"));
  CHECK(report.t <= 0.51);  // midpoint asks a quarter of its last, doubled step before its end
  CHECK(report.t >= 0.49);
  CHECK(y.allFinite());
  CHECK(distance(y, Vec(Vec(1, 2) * std::exp(-report.t))) <= 1e-3);
}
void for_each_scheme(auto&& f) {
  f("backward_euler", backward_euler), f("phi(0.7)", phi(0.7)), f("trapezoidal", trapezoidal), f("midpoint", midpoint);
  f("tr_bdf2", tr_bdf2), f("forward_euler", forward_euler), f("rannacher", rannacher);
}

/// That nothing has happened to (1, 2) when a run from t0 was refused.
inline void check_refused(const RunReport& report, const Vec& y, double t0, int shown) {
  CHECK(shown == 0);
  CHECK(y == Vec(1, 2));
  CHECK(report.t == Approx(t0));
  CHECK(report.statistics == Statistics{});
  CHECK_FALSE(report.message().empty());
}
RunReport refusal(const auto& control, TimeSpan<double> span = {0, 1}) {
  Vec y(1, 2);
  PhiStepper stepper{y, decay, trapezoidal};
  int shown = 0;
  const RunReport report = integrate(stepper, y, span, control, Look([&](double, const Vec&) { ++shown; }));
  check_refused(report, y, span.t0, shown);
  return report;
}

inline const auto meet_pole = [](const char* name, auto scheme) {
  CAPTURE(name);
  Vec y(1, 0.5);
  PhiStepper stepper{y, square, scheme};
  double shown = 0;
  Vec last = y;
  // An order-1 scheme takes 1/(√2 rtol) steps while y grows e-fold, and y grows by e^37 until Δt is rounding: 26,000
  // steps at rtol = 1e-3.
  const RunReport report = integrate(stepper, y, {0, 3}, tolerance{.rtol = 1e-3, .max_steps = 200'000},
                                     Look([&](double t, const Vec& now) { shown = t, last = now; }));
  check_at_pole(report, y, shown, last);
};

/// Returns what limited most of its steps.
inline const auto meet_nan = [](const char* name, auto scheme) {
  CAPTURE(name);
  const Psi force = [](const Vec& y, double t) -> Vec { return t > 0.5 ? Vec(NaN, 1) : Vec(-y); };
  Vec y(1, 2);
  PhiStepper stepper{y, force, scheme};
  const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-4, .max_steps = 10'000});
  check_before_nan(report, y);
  return report.limits.most().by;
};

inline const auto pass_jump = [](const char* name, auto scheme) {
  CAPTURE(name);
  const Psi force = [](const Vec&, double t) -> Vec { return t < 1.0 / 3 ? Vec(1, -1) : Vec(-2, 5); };
  Vec y(0.5, 0.5);
  PhiStepper stepper{y, force, scheme};
  const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-4, .max_steps = 5000});
  REQUIRE(report);
  CHECK(distance(y, Vec(0.5 + 1.0 / 3 - 4.0 / 3, 0.5 - 1.0 / 3 + 10.0 / 3)) <= 1e-3);
};

/// A force that throws, at whatever call.
void check_throws(auto start, auto psi, auto scheme, auto&& exact, const auto& control) {
  int calls = 0, fatal = 0;
  const auto force = [&calls, &fatal, psi](const auto&... args) {
    if (++calls == fatal) throw std::runtime_error("no more");
    return psi(args...);
  };
  using S = decltype(start);
  int total = 0;
  for (int k = 0; k == 0 || k <= total; k += 1 + k / 40) {
    S y = start, last = start;
    calls = 0, fatal = k;
    PhiStepper stepper{
        y,
        typename std::conditional_t<Blocks<S>::drifts,
                                    std::type_identity<std::function<Vec(const Vec&, const Vec&, double)>>,
                                    std::type_identity<std::function<Vec(const Vec&, double)>>>::type(force),
        scheme};
    Run run{stepper, y, {0.0, 1.0}, control};
    int thrown = 0;
    double t = 0;
    for (bool more = true; more;) {
      try {
        more = run.advance();
      } catch (const std::runtime_error&) {
        ++thrown;
        CHECK(run.time() == t);
        CHECK(states::same_bits(states::numbers(y), states::numbers(last)));
        CHECK_FALSE(run.has_ended());
      }
      last = y, t = run.time();
    }
    CAPTURE(k, run.report().message());
    CHECK(run.report());
    CHECK(run.time() == 1);
    CHECK(distance(y, exact(1.0)) <= 1e-2);
    if (k == 0) total = calls;
    else CHECK(thrown == 1);
  }
}

inline const auto flow = [](const Vec& y, double t) -> Vec { return Flow{}(y, t) / Flow::capacity; };

}  // namespace runs_cases
