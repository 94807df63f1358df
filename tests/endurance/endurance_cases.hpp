#pragma once

// Long runs of an oscillator and of the clock: what both halves of endurance/endurance need.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "endurance/drift.hpp"
#include "problems/show_digits.hpp"
#include "support/catch.hpp"

namespace {

template <class T>
using One = Eigen::Matrix<T, 1, 1>;

/// The energy of an affine oscillator, a = ωΔt.
template <class T>
endurance::Trend energy_of(auto scheme, T a, std::int64_t steps) {
  phistep::Motion<One<T>> y{One<T>(T{1}), One<T>(T(0.3) * a)};
  phistep::PhiStepper stepper{y, phistep::linear(One<T>(-a * a)), scheme};
  const auto energy = [&] {
    const long double r = y.r[0], v = y.v[0];
    return v * v + static_cast<long double>(a * a) * r * r;
  };
  const long double start = energy();
  return endurance::follow(
             {""}, steps,
             [&](std::int64_t from, std::int64_t to) {
               REQUIRE(phistep::integrate(stepper, y, {T{0}, static_cast<T>(to - from)}, phistep::fixed(1)));
             },
             [&] { return std::array{energy() / start - 1}; })[0]
      .trend();
}

/// As in oscillator.stress: no more than 2u·max(1, a/2) a step, √n steps, five times that.
template <class T>
void check_energy(T a, auto scheme) {
  const auto trend = energy_of(scheme, a, 1000000);
  const double step = static_cast<double>(std::numeric_limits<T>::epsilon()) * std::max(1.0, double(a) / 2);
  CAPTURE(a, trend.slope, trend.t);
  CHECK(trend.worst <= 5e3 * step);
  CHECK(std::abs(trend.t) < 5);
}
/// Of a million steps, each.
template <class T>
void check_time(T t0, T dt) {
  constexpr std::int64_t n = 1000000;
  const T t1 = t0 + static_cast<T>(n) * dt;
  One<T> y{T{1}};
  phistep::PhiStepper stepper{y, phistep::linear(One<T>{T{0}}), phistep::forward_euler};
  std::int64_t k = 0, wrong = 0;
  const auto look = [&](T t, const auto&) { wrong += t != t0 + static_cast<T>(k++) * dt; };
  const auto report = phistep::integrate(stepper, y, {t0, t1}, phistep::fixed(static_cast<double>(dt)), look);
  REQUIRE(report);
  CHECK(wrong == 0);
  CHECK(k == n + 1);
  CHECK(report.t == static_cast<double>(t1));
}

}  // namespace
