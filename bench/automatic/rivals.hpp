/// @file
/// What other automatic solvers see of a problem: y' = f(t, y) on bare arrays.
#pragma once

#include <Eigen/Core>

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace automatic {

struct BareProblem {
  Eigen::VectorXd start;
  double end, a;  ///< atol = a·rtol
  std::function<void(double t, const double* y, double* out)> rate;
};
/// y at the end; empty where it failed.
using RivalRun = std::function<Eigen::VectorXd(double rtol)>;
/// LSODA, which switches between Adams and BDF by itself, and CVODE with each of the two: those that were found. Their
/// Jacobians are dense differences.
[[nodiscard]] std::vector<std::pair<std::string, RivalRun>> rivals_of(const BareProblem& problem);

}  // namespace automatic
