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
inline void for_each_quick_scheme(auto&& f) { f("trapezoidal", trapezoidal); }
inline void for_each_scheme(auto&& f) {
  f("backward_euler", backward_euler), f("phi(0.7)", phi(0.7)), f("trapezoidal", trapezoidal), f("midpoint", midpoint);
  f("tr_bdf2", tr_bdf2), f("forward_euler", forward_euler), f("rannacher", rannacher);
}

}  // namespace runs_cases
