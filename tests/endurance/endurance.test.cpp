// What the long programs of this folder show, in a second; and that their way to tell a drift from a walk can. A heap
// of grains: the stress tier.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "endurance/drift.hpp"
#include "problems/show_digits.hpp"
#include "support/catch.hpp"
#if PHISTEP_FULL
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#endif
#if PHISTEP_STRESS
#include <phistep/particles.hpp>

#include "problems/pyramid.hpp"
#endif

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

#if PHISTEP_FULL

namespace {

/// 256 samples a thousand steps apart, of a walk of 1 a step, a drift, swings and a walk's integral.
endurance::Trend trend_of(unsigned seed, double walk, double drift, double swing, double integral, int order = 1) {
  std::mt19937_64 random{seed};
  std::normal_distribution<double> normal;
  endurance::Series series{.name = "", .stride = 1000};
  double w = 0, sum = 0;
  for (int k = 1; k <= 256; ++k) {
    w += std::sqrt(1000.0) * normal(random);
    sum += w;
    series.e.push_back(walk * w + drift * 1000 * k + swing * normal(random) + integral * sum);
  }
  auto trend = series.trend();
  trend.exponent = series.exponent(order);
  return trend;
}

}  // namespace

TEST_CASE("a drift is told from a random walk, and from what swings") {
  // |t| ≤ 5 but once in a million; a drift of half a deviation a sample has t = 8, ± 1.
  int drifts = 0;
  double exponents = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const auto walk = trend_of(seed, 1, 0, 0, 0);
    drifts += std::abs(walk.t) > 2;
    exponents += walk.exponent / 200;
    CHECK(std::abs(walk.t) < 5);
    CHECK(std::abs(trend_of(seed, 1, 0, 1e3, 0).t) < 5);
    CHECK(trend_of(seed, 1, 0.5 / std::sqrt(1000.0), 0, 0).t > 4);
  }
  // Beyond 2: 4.6 % of 200, ± 3.
  CHECK(drifts >= 1);
  CHECK(drifts <= 21);
  CHECK(exponents == Approx(0.5).margin(0.05));
  const auto drift = trend_of(1, 1, 1, 0, 0);
  CHECK(drift.slope == Approx(1).margin(5 * drift.error));
  CHECK(drift.exponent == Approx(1).margin(0.02));
  CHECK(trend_of(1, 0, 0, 1, 0).exponent == Approx(0).margin(0.05));
  CHECK(trend_of(1, 0, 0, 0, 1, 2).exponent == Approx(1.5).margin(0.25));
}

TEST_CASE("an affine oscillator at phi = 1/2: a million steps, a random walk") {
  check_energy(0.1, phistep::midpoint);
  check_energy(30.0, phistep::midpoint);
}

TEST_CASE("time is t0 + n dt to the bit, in every one of a million steps, in float too") {
  check_time(0.0, 0.1);
  check_time(0.0F, 0.1F);
}

TEST_CASE("Kepler, SRKN6b: a hundred thousand steps, neither energy nor angular momentum drift") {
  const problems::Kepler kepler;
  auto y = kepler.start();
  phistep::PhiStepper stepper{y, kepler, phistep::srkn6b};
  const double h = problems::Kepler::period / 103;  // samples 400 steps apart see all of the orbit
  const auto energy = [](const auto& x) { return x.v.squaredNorm() / 2 - 1 / x.r.norm(); };
  const double E = energy(y), L = problems::Kepler::angular_momentum(y);
  const auto series = endurance::follow(
      {"", ""}, 102400,
      [&](std::int64_t from, std::int64_t to) {
        REQUIRE(phistep::integrate(stepper, y, {double(from) * h, double(to) * h}, phistep::fixed(h)));
      },
      [&] {
        return std::array{energy(y) / E - 1, problems::Kepler::angular_momentum(y) / L - 1};
      });
  CHECK(std::abs(series[0].trend().t) < 5);
  CHECK(std::abs(series[1].trend().t) < 5);
  // Six kicks and drifts a step round r × v by 2u at most, of up to 1.25 L; five deviations.
  CHECK(series[1].worst() <= 5 * 2 * 1.25 * 1.1e-16 * std::sqrt(102400 * 12));
}

#elif PHISTEP_STRESS
// What the long programs of this folder show: every rounding of an oscillator, and a heap of grains.

TEST_CASE("an affine oscillator at phi = 1/2: a million steps, a random walk") {
  check_energy(0.1, phistep::midpoint);
  check_energy(3.0, phistep::trapezoidal);
  check_energy(30.0, phistep::midpoint);
  check_energy(3.0F, phistep::midpoint);
}

TEST_CASE("a pyramid of grains stands by friction, and does not move by a bit more than one rounding") {
  using problems::Pyramid;
  const Pyramid scene{.side = 2, .tilt = 0.05};
  auto y = scene.start();
  phistep::PhiStepper stepper{y, scene.force(), phistep::symplectic_euler};
  const double h = Pyramid::dt();
  REQUIRE(phistep::integrate(stepper, y, {0.0, 1e5 * h}, phistep::fixed(h)));
  const auto rest = y;
  REQUIRE(phistep::integrate(stepper, y, {1e5 * h, 2e5 * h}, phistep::fixed(h)));
  CHECK((y.r - rest.r).cwiseAbs().maxCoeff() <= 0x1p-50);
  CHECK(y.v.cwiseAbs().maxCoeff() * h <= 0x1p-50);
  CHECK(y.r.row(2).maxCoeff() == Approx(scene.start().r.row(2).maxCoeff()).epsilon(0.01));
}

#endif
