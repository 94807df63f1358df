// What the long programs of this folder show, in a second; and that their way to tell a drift from a walk can. A heap
// of grains: endurance.full.cpp.
#include "endurance/endurance_cases.hpp"

#include <random>

#include "problems/kepler.hpp"
#include "problems/march.hpp"

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
