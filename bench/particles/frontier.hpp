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

#include "../equal_error.hpp"
#include "rows.hpp"

namespace bench {

struct Rung {
  std::string method;
  double dt = 0, error = 0, drift = 0;  ///< in a stated observable; of the energy
  Entrant entrant{};
};

/// The least time in which `method` has an error of at most `wanted` (equal_error.hpp).
[[nodiscard]] inline std::optional<double> time_to(double wanted, const std::string& method,
                                                   const std::vector<Rung>& rungs) {
  std::vector<std::pair<double, double>> runs;
  for (const Rung& rung : rungs)
    if (rung.method == method && !rung.entrant.times.empty()) runs.emplace_back(rung.entrant.median(), rung.error);
  return time_to_error(wanted, std::move(runs));
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
