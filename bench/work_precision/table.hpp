/// @file
/// Work against precision: how long a method takes to reach how small an error. Each problem is a table of methods, each
/// method a ladder of runs by one parameter, Δt or rtol.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace work_precision {

/// What a run reached, and what it took.
struct Answer {
  Eigen::VectorXd y;  ///< at the end time; empty where the run failed
  std::int64_t steps = 0, force_calls = 0, jacobians = 0, factorizations = 0;
};

/// One method on one problem. Each call of `run` is a run from nothing: set-up, memory and all.
struct Method {
  std::string name;
  std::string parameter;       ///< what the ladder is of: "dt" or "rtol"
  std::vector<double> ladder;  ///< from coarse to fine
  std::function<Answer(double)> run;
};

/// A problem: its answer, and who tries to find it.
struct Table {
  std::string name;
  std::string title;
  Eigen::VectorXd exact;
  double a;  ///< atol = a·rtol
  std::vector<Method> methods{};
  std::vector<Eigen::Index> samples{};  ///< where `exact` holds these components only

  /// max |y_i − exact_i| / (|exact_i| + a); infinite where there is no answer or one that isn't finite
  [[nodiscard]] double error(const Answer& answer) const {
    double largest = 0;
    for (Eigen::Index k = 0; k < exact.size(); ++k) {
      const Eigen::Index i = samples.empty() ? k : samples[static_cast<std::size_t>(k)];
      if (i >= answer.y.size() || !std::isfinite(answer.y[i])) return std::numeric_limits<double>::infinity();
      largest = std::max(largest, std::abs(answer.y[i] - exact[k]) / (std::abs(exact[k]) + a));
    }
    return largest;
  }
};

/// 10^from … 10^to by factors of √10 (the tolerances are the same for everybody).
[[nodiscard]] inline std::vector<double> tolerances(double from = -1, double to = -8) {
  std::vector<double> ladder;
  for (double k = from; k >= to; k -= 0.5) ladder.push_back(std::pow(10.0, k));
  return ladder;
}
/// end/n for n = from, 2 from, … to
[[nodiscard]] inline std::vector<double> steps(double end, int from, int to) {
  std::vector<double> ladder;
  for (int n = from; n <= to; n *= 2) ladder.push_back(end / n);
  return ladder;
}

// One file a problem.
[[nodiscard]] Table hires();
[[nodiscard]] Table robertson();
[[nodiscard]] Table van_der_pol();
[[nodiscard]] Table kepler();
[[nodiscard]] Table brusselator_1d();
[[nodiscard]] Table heat_2d();
[[nodiscard]] Table spring_network();

}  // namespace work_precision
