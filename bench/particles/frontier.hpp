/// @file
/// Error against time: the runs of a method over a ladder of Δt, and the time to a wanted error.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rows.hpp"

namespace bench {

struct Rung {
  std::string method;
  double dt = 0, error = 0, drift = 0;  ///< in a stated observable; of the energy
  Entrant entrant{};
};

/// The least time in which `method` has an error of at most `wanted`: between two rungs by a straight line through the
/// logarithms.
[[nodiscard]] inline std::optional<double> time_to(double wanted, const std::string& method,
                                                   const std::vector<Rung>& rungs) {
  std::vector<std::pair<double, double>> front;
  for (const Rung& rung : rungs)
    if (rung.method == method && !rung.entrant.times.empty())
      front.emplace_back(rung.entrant.median(), std::max(rung.error, 1e-16));
  std::sort(front.begin(), front.end());
  double before_time = 0, before_error = 0;
  for (const auto& [time, error] : front) {
    if (before_time > 0 && error >= before_error) continue;
    if (error <= wanted) {
      if (before_time == 0) return time;
      return before_time *
             std::pow(time / before_time, std::log(before_error / wanted) / std::log(before_error / error));
    }
    before_time = time;
    before_error = error;
  }
  return std::nullopt;
}

/// Medians of all rungs, in turns.
inline void take_turns(std::vector<Rung>& rungs, int rounds) {
  for (int round = 0; round < rounds; ++round)
    for (Rung& rung : rungs) rung.entrant.times.push_back(rung.entrant.run());
}

/// Appends to DIR/particles_<name>.csv, which plot.py draws.
void write_rungs(const Options& options, const std::string& name, const std::string& scene,
                 const std::vector<Rung>& rungs, bool is_first);

}  // namespace bench
