#pragma once

// Errors over many steps: what grows in proportion to their number n, a drift, told apart from what rounding alone does, a
// random walk, ∝ √n (Brouwer's law; its integral, a phase, goes as n^(3/2)), and from what stays bounded.
//
// A series e(n) is sampled at equal distances. Under the hypothesis "random walk, bounded swings added or not" the K
// increments between samples have mean 0, so that
//
//     t = √K · mean / standard deviation
//
// is Student's t of K − 1 degrees of freedom. Swings that return make successive increments opposite, which leaves |t|
// smaller: the test errs to the safe side, unless the samples keep in step with a swing. |t| > 5 has a probability of 1e-6
// for 255 degrees: then it drifts, by slope ± error a step. The exponent H is that of the structure function,
// rms(e(n+m) − e(n)) ∝ m^H: ½ for a random walk, 1 for a drift, 0 for swings; 3/2 for a phase, by second differences, for
// first ones see no more than 1.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "support/figures.hpp"

namespace endurance {

/// What becomes of e(n).
struct Trend {
  double slope = 0;     ///< [1/step] mean growth
  double error = 0;     ///< [1/step] its standard error under the random walk
  double t = 0;         ///< slope/error
  double exponent = 0;  ///< H
  double worst = 0;     ///< max |e|
  double walk = 0;      ///< [1/√step] of the random walk that would have these increments
};

/// e at n = 1, 2, 4, … and at `samples` equal distances.
struct Series {
  std::string name;
  std::int64_t stride = 1;                             ///< [steps] between samples
  std::vector<double> e{0};                            ///< at n = 0, stride, 2 stride, …
  std::vector<std::pair<std::int64_t, double>> all{};  ///< (n, e) of all

  [[nodiscard]] double worst() const {
    double most = 0;
    for (const auto& [n, x] : all) most = x == x ? std::max(most, std::abs(x)) : std::abs(x) + INFINITY;
    return most;
  }
  [[nodiscard]] Trend trend() const {
    Trend trend;
    const auto K = static_cast<std::int64_t>(e.size()) - 1;
    const double count = static_cast<double>(K), m = static_cast<double>(stride);
    const double mean = (e.back() - e.front()) / count;
    double squares = 0;
    for (std::size_t k = 0; k + 1 < e.size(); ++k) squares += std::pow(e[k + 1] - e[k] - mean, 2);
    const double deviation = std::sqrt(squares / (count - 1));
    trend.slope = mean / m;
    trend.error = deviation / std::sqrt(count) / m;
    trend.t = trend.error > 0 ? trend.slope / trend.error : mean == 0 ? 0 : INFINITY;
    trend.walk = deviation / std::sqrt(m);
    trend.worst = worst();
    trend.exponent = exponent(1);
    return trend;
  }
  /// H from differences of the given order (2 for a phase), by least squares over lags 1, 2, 4, …, K/8.
  [[nodiscard]] double exponent(int order) const {
    const auto K = e.size() - 1;
    double n = 0, x1 = 0, y1 = 0, xx = 0, xy = 0;
    for (std::size_t lag = 1; lag <= K / 8; lag *= 2) {
      double squares = 0, terms = 0;
      for (std::size_t k = 0; k + lag * static_cast<std::size_t>(order) <= K; ++k, ++terms)
        squares += order == 1 ? std::pow(e[k + lag] - e[k], 2) : std::pow(e[k + 2 * lag] - 2 * e[k + lag] + e[k], 2);
      if (!(squares > 0)) continue;
      const double x = std::log(static_cast<double>(lag)), y = std::log(squares / terms) / 2;
      n += 1, x1 += x, y1 += y, xx += x * x, xy += x * y;
    }
    return n < 2 ? 0 : (xy - x1 * y1 / n) / (xx - x1 * x1 / n);
  }
};

/// Where PHISTEP_SERIES names a folder, the series are written there, to be drawn.
inline void write(const Series& series) {
  const char* folder = std::getenv("PHISTEP_SERIES");
  if (folder == nullptr) return;
  std::filesystem::create_directories(folder);
  std::ofstream out{std::filesystem::path{folder} / (series.name + ".csv")};
  out << "steps,error\n";
  for (const auto& [n, x] : series.all) out << n << ',' << x << '\n';
}

/// advance(n, m) goes from step n to step m; measure() returns the errors there, in the order of their names.
template <class Advance, class Measure>
[[nodiscard]] std::vector<Series> follow(const std::vector<std::string>& names, std::int64_t steps, Advance&& advance,
                                         Measure&& measure, std::int64_t samples = 256) {
  using Clock = std::chrono::steady_clock;
  std::vector<Series> all;
  for (const auto& name : names) all.push_back({.name = name, .stride = steps / samples});
  const std::int64_t stride = steps / samples;
  auto told = Clock::now();
  std::int64_t n = 0;
  for (std::int64_t next = 1; n < steps;) {
    advance(n, next);
    n = next;
    const auto errors = measure();
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto x = static_cast<double>(errors[i]);
      all[i].all.emplace_back(n, x);
      if (n % stride == 0) all[i].e.push_back(x);
    }
    next = 2 * n < stride ? 2 * n : (n / stride + 1) * stride;
    if (Clock::now() - told > std::chrono::seconds{15}) {
      told = Clock::now();
      figures::progress(names.front() + ", step " + std::to_string(n));
    }
  }
  for (const Series& series : all) write(series);
  return all;
}

}  // namespace endurance
