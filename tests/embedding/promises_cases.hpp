#pragma once

// What the quick and the full half of embedding/promises share: forces that count, and what continues with the same bits.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "support/catch.hpp"

namespace promises_cases {

using namespace phistep;
using Vec = Eigen::Vector3d;
using Y = Motion<Vec>;

inline const Y start{Vec{1, 0.5, -0.3}, Vec{0, 0.2, 0.1}};

[[nodiscard]] inline bool same(const Vec& a, const Vec& b) { return equal_bits(std::tie(a), std::tie(b)); }
[[nodiscard]] inline bool same(const Y& a, const Y& b) { return same(a.r, b.r) && same(a.v, b.v); }
[[nodiscard]] inline double distance(const Vec& a, const Vec& b) { return (a - b).cwiseAbs().maxCoeff(); }
[[nodiscard]] inline double distance(const Y& a, const Y& b) {
  return std::max(distance(a.r, b.r), distance(a.v, b.v));
}

/// What a force has been through, and what it is to do.
struct Diary {
  int calls = 0, not_finite = 0;
  int nan_from = -1, throw_at = -1;  // from which call on it returns NaN; at which it throws
};
struct Struck : std::runtime_error {
  Struck() : std::runtime_error("struck") {}
};

/// A nonlinear spring that couples all components.
struct Anchored {
  Diary* diary;
  Vec operator()(const Vec& r) const {
    ++diary->calls;
    diary->not_finite += r.allFinite() ? 0 : 1;
    if (diary->calls == diary->throw_at) throw Struck();
    if (diary->nan_from >= 0 && diary->calls >= diary->nan_from)
      return Vec::Constant(std::numeric_limits<double>::quiet_NaN());
    return -4 * r.array().sin() - 3 * r.array().cube() - 0.5 * (r[0] - r[1]);
  }
};
/// The same with friction.
struct Damped : Anchored {
  Vec operator()(const Vec& r, const Vec& v) const {
    if (!v.allFinite() && r.allFinite()) ++diary->not_finite;
    return Anchored::operator()(r) - (0.3 * v.array().cube()).matrix();
  }
};
/// The same with a force that swings.
struct Driven {
  static constexpr bool uses_velocity = false;
  Diary* diary;
  void add(double t, const auto& y, auto& out) const {
    out.force += Anchored{diary}(y.r);
    out.force.array() += std::sin(5 * t);
  }
};

/// Calls of the force in each of twelve steps; they agree with the statistics.
template <class F>
std::vector<int> calls_of_steps(auto scheme, const auto&... more) {
  Diary diary;
  Y y = start;
  PhiStepper stepper{y, F{&diary}, scheme, more...};
  std::vector<int> calls;
  for (int n = 0; n < 12; ++n) {
    const int before = diary.calls;
    REQUIRE(stepper.step(y, n * 0.0625, 0.0625));
    calls.push_back(diary.calls - before);
  }
  CHECK(stepper.statistics().force_calls + stepper.statistics().checks == diary.calls);
  return calls;
}
/// `first` in the first step, `later` in the other eleven.
[[nodiscard]] inline std::vector<int> steps_of(int first, int later) {
  std::vector<int> all(12, later);
  all[0] = first;
  return all;
}

struct Continued {
  int same_bits = 0;  ///< of 28 steps, those that end in the same bits
  double apart = 0;   ///< and how far apart the others end, at most
};
/// Twelve steps; then a program that goes on, beside one that makes a new stepper from r, v and t. `resets`: the first calls
/// reset() there.
template <class F>
Continued continued(double dt, int saved_after, bool resets, auto scheme, const auto&... more) {
  Diary diary;
  Y a = start;
  PhiStepper goes_on{a, F{&diary}, scheme, more...};
  for (int n = 0; n < saved_after; ++n) REQUIRE(goes_on.step(a, n * dt, dt));
  Y b = a;
  if (resets) goes_on.reset();
  PhiStepper restarted{b, F{&diary}, scheme, more...};
  Continued all;
  for (int n = saved_after; n < saved_after + 28; ++n) {
    REQUIRE((goes_on.step(a, n * dt, dt) && restarted.step(b, n * dt, dt)));
    all.same_bits += same(a, b) ? 1 : 0;
    all.apart = std::max(all.apart, distance(a, b));
  }
  return all;
}
template <class F = Anchored>
void check_same_bits(auto scheme, const auto&... more) {
  for (const double dt : {0.0625, 0.1}) CHECK(continued<F>(dt, 12, false, scheme, more...).same_bits == 28);
}
/// Rounding apart, and with reset() where the state is saved not even that.
template <class F = Anchored>
void check_rounding(auto scheme, const auto&... more) {
  int all = 0;
  for (const double dt : {0.0625, 0.1}) {
    const Continued plain = continued<F>(dt, 12, false, scheme, more...);
    CHECK(plain.apart < 2e-14);
    all += plain.same_bits;
    CHECK(continued<F>(dt, 12, true, scheme, more...).same_bits == 28);
  }
  CHECK(all < 56);
}

/// A fault in every call, and steps that overflow: what the force was called with, and whether the state kept its bits.
template <class F>
void check_never_called_with_nan(auto scheme, const auto&... more) {
  int failed_steps = 0, kept = 0, bad = 0;
  const auto step = [&](auto& stepper, Y& y, double t, double dt) {
    const Y before = y;
    if (stepper.step(y, t, dt)) return;
    ++failed_steps;
    kept += same(y, before) ? 1 : 0;
  };
  for (int at = 1; at <= 30; ++at) {
    Diary diary{.nan_from = at};
    Y y = start;
    PhiStepper stepper{y, F{&diary}, scheme, more...};
    for (int n = 0; n < 4; ++n) step(stepper, y, n * 0.1, 0.1);
    bad += diary.not_finite;
  }
  for (const double dt : {1e60, 1e150, 1e300}) {
    Diary diary;
    Y y = start;
    PhiStepper stepper{y, F{&diary}, scheme, more...};
    step(stepper, y, 0, dt);
    bad += diary.not_finite;
  }
  CHECK(bad == 0);
  CHECK(failed_steps > 5);
  CHECK(kept == failed_steps);
}

/// The same in runs under a tolerance.
template <class F>
void check_runs_never_call_with_nan(auto scheme, const auto&... more) {
  int failed_runs = 0, bad = 0;
  for (int at = 1; at <= 40; ++at) {
    Diary diary{.nan_from = at};
    Y y = start;
    PhiStepper stepper{y, F{&diary}, scheme, more...};
    failed_runs += integrate(stepper, y, {0, 5}, tolerance{.rtol = 1e-4, .atol = 1e-6}) ? 0 : 1;
    bad += diary.not_finite;
  }
  CHECK(bad == 0);
  CHECK(failed_runs == 40);
}

}  // namespace promises_cases
