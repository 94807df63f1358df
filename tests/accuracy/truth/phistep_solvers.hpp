#pragma once

// The library's schemes, compiled once (phistep_solvers.cpp).

#include <vector>

#include "accuracy/truth/count.hpp"
#include "accuracy/truth/solution.hpp"

namespace truth {

[[nodiscard]] std::vector<Solver> phistep_solvers();

/// y(end) by Radau in long double, which has nothing in common with the extrapolation that makes the answers.
[[nodiscard]] Eigen::VectorXd by_radau(const Any& network, const Problem& problem);

}  // namespace truth
