// The clock of runs of up to 10⁸ steps: t₀ + nΔt to the bit, t₁ to the bit; of steps of many lengths, a compensated sum.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "support/catch.hpp"
#include "support/figures.hpp"

namespace {

template <class T>
using One = Eigen::Matrix<T, 1, 1>;
/// The cheapest motion there is.
struct Still {
  template <class T>
  One<T> operator()(const One<T>& y) const {
    return 0 * y;
  }
};

/// How many of n steps of dt end at another number than t0 + kΔt, and the last at another than t1.
template <class T>
void check_grid(T t0, T dt, std::int64_t n) {
  const T t1 = t0 + static_cast<T>(n) * dt;
  One<T> y{T{1}};
  phistep::PhiStepper stepper{y, Still{}, phistep::forward_euler};
  std::int64_t k = 0, wrong = 0;
  T last = t0;
  const auto look = [&](T t, const auto&) {
    wrong += k > 0 && t != (k == n ? t1 : t0 + static_cast<T>(k) * dt);
    wrong += k > 0 && !(dt > 0 ? t > last : t < last);
    last = t;
    ++k;
  };
  const auto report = phistep::integrate(stepper, y, {t0, t1}, phistep::fixed(static_cast<double>(dt)), look);
  REQUIRE(report);
  const std::string which = std::string(sizeof(T) == 4 ? "float, " : "double, ") + figures::text(double(n)) +
                            " steps of " + figures::text(static_cast<double>(dt));
  figures::at_most(0, static_cast<double>(wrong), "t = t0 + n dt to the bit, every step", which + ": other times");
  figures::at_most(0, std::abs(static_cast<double>(report.statistics.steps - n)), "as many steps as there are", which);
  figures::at_most(0, std::abs(report.t - static_cast<double>(t1)), "the last time is t1 to the bit", which);
  T sum = t0;
  for (std::int64_t i = 0; i < n; ++i) sum += dt;
  figures::told(std::abs(static_cast<double>(sum) - static_cast<double>(t1)), "a plain sum t += dt",
                which + ": off by");
}

/// y' = cos ωt: what a controlled run takes steps of all lengths for.
struct Beat {
  One<double> operator()(const One<double>& /*y*/, double t) const { return One<double>{std::cos(t)}; }
};

}  // namespace

TEST_CASE("steps of one length: time is t0 + n dt, to the bit, over 1e8 steps") {
  check_grid<double>(0, 0.1, 100000000);
  check_grid<double>(-1234.5, 1.0 / 3, 10000000);
  check_grid<double>(1e6, -1e-3, 1000000);
}

TEST_CASE("in float, too, as far as a float can tell t from t + dt") {
  check_grid<float>(0, 0.1F, 1000000);
  // From 2²³ steps on, successive times of the grid need more bits than there are.
  check_grid<float>(0, 0.25F, 1 << 22);
}

TEST_CASE("steps of many lengths: a compensated sum") {
  // The sum of all lengths in extended precision; each length is what the scheme was called with.
  One<double> y{0.0};
  phistep::PhiStepper stepper{y, Beat{}, phistep::trapezoidal};
  long double sum = 0;
  double naive = 0, worst = 0, worst_naive = 0;
  std::int64_t steps = 0;
  const auto look = [&](const auto& step) {
    sum += static_cast<long double>(step.dt());
    naive += step.dt();
    const auto t = static_cast<long double>(step.t1());
    worst = std::max(worst, static_cast<double>(std::abs(t - sum)));
    worst_naive = std::max(worst_naive, static_cast<double>(std::abs(static_cast<long double>(naive) - sum)));
    ++steps;
  };
  const auto report = phistep::integrate(stepper, y, {0.0, 1e5}, phistep::tolerance{.rtol = 1e-4, .atol = 1e-4}, look);
  REQUIRE(report);
  const std::string which = figures::text(static_cast<double>(steps)) + " steps of " +
                            figures::text(report.smallest_dt) + " to " + figures::text(report.largest_dt);
  // Half a unit in the last place of the time itself, and of the first carry.
  figures::at_most(0x1p-52 * 1e5, worst, "variable steps: t is the sum of dt to a rounding", which + ": max error");
  figures::told(worst_naive, "a plain sum t += dt", which + ": off by");
  figures::at_most(0, std::abs(report.t - 1e5), "the last time is t1 to the bit", which);
}
