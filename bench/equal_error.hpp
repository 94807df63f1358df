/// @file
/// The time at which a method reaches an error, from its runs at several tolerances.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace bench {

/// The least time in which the error is at most `wanted`: on the front of the runs that no other beats in both, and between two
/// of them by a straight line through the logarithms. Nothing where it isn't reached.
/// @param runs  (time, error) of each
[[nodiscard]] inline std::optional<double> time_to_error(double wanted, std::vector<std::pair<double, double>> runs) {
  for (auto& [time, error] : runs) error = std::max(error, 1e-16);
  std::sort(runs.begin(), runs.end());
  double before_time = 0, before_error = 0;
  for (const auto& [time, error] : runs) {
    if (before_time > 0 && error >= before_error) continue;
    if (error <= wanted) {
      if (before_time == 0) return time;
      const double share = std::log(before_error / wanted) / std::log(before_error / error);
      return before_time * std::pow(time / before_time, share);
    }
    before_time = time;
    before_error = error;
  }
  return std::nullopt;
}

}  // namespace bench
