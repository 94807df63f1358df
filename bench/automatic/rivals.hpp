/// @file
/// What other solvers see of a problem: y' = f(t, y) on bare arrays.
#pragma once

#include <Eigen/Core>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace automatic {

struct BareProblem {
  Eigen::VectorXd start;
  double end, a;  ///< atol = a·rtol
  void (*rate)(void* self, double t, const double* y, double* out);
  std::shared_ptr<void> self;
};
constexpr long most_calls = 3'000'000;  ///< of a run by solvers that never give up by themselves

/// y at the end; empty where it failed.
using RivalRun = std::function<Eigen::VectorXd(double rtol)>;
using Rivals = std::vector<std::pair<std::string, RivalRun>>;
/// Those that were found of LSODA, which switches between Adams and BDF by itself, DOP853, CVODE and GSL, with methods for stiff
/// problems and for others. Their Jacobians are dense differences.
[[nodiscard]] Rivals rivals_of(const BareProblem& problem);
/// Odeint's rosenbrock4 with a Jacobian by dense differences, and its explicit pairs.
[[nodiscard]] Rivals odeint_rivals(const BareProblem& problem);

/// J[i n + j] = df_i/dy_j, forward differences; by_time = df/dt.
void jacobian_by_differences(const BareProblem& problem, double t, const double* y, double* J, double* by_time);

}  // namespace automatic
