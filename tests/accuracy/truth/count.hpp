#pragma once

// Runs counted: what failed and says so, and what says "success" and is wrong.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "accuracy/truth/problem.hpp"

namespace truth {

[[nodiscard]] inline bool has_jacobian(const Problem& problem) { return static_cast<bool>(problem.jacobian); }
[[nodiscard]] inline bool is_motion(const Problem& problem) { return problem.kind == Kind::motion; }
[[nodiscard]] inline bool is_not_stiff(const Problem& problem) {
  return problem.kind == Kind::smooth || problem.kind == Kind::motion;
}

/// Who needs more has lost the solution: the same number for everybody.
constexpr long most_steps = 20000;

struct Solver {
  std::string library, name;
  double tightest;  ///< of rtol
  std::function<bool(const Problem&)> suits;
  std::function<Answer(const Problem&, double rtol)> run;
};

/// One run: its error in units of κ·rtol; negative where the solver said that it failed.
struct Result {
  std::size_t solver, problem;
  double rtol, share;
  double drift = 0;      ///< of what is conserved: relative; 0 where nothing is known to be
  double roundings = 0;  ///< the same in units of Problem::rounding_of_conserved
  double least = 0;      ///< y_min/(max y), below 0 where a concentration is negative
};

struct Tally {
  int runs = 0, failed = 0, above_10 = 0, above_100 = 0;
  double worst = 0, worst_rtol = 0;
  std::size_t worst_problem = 0;

  void add(const Result& result) {
    ++runs;
    if (result.share < 0) {
      ++failed;
      return;
    }
    above_10 += !(result.share <= 10);
    above_100 += !(result.share <= 100);
    if (!(result.share <= worst)) worst = result.share, worst_rtol = result.rtol, worst_problem = result.problem;
  }
  void add(const Tally& other) {
    runs += other.runs, failed += other.failed, above_10 += other.above_10, above_100 += other.above_100;
    if (other.worst > worst) worst = other.worst, worst_rtol = other.worst_rtol, worst_problem = other.worst_problem;
  }
  /// Wrong successes in a thousand runs.
  [[nodiscard]] double per_thousand() const { return runs ? 1000.0 * above_100 / runs : 0; }
};

/// One run, judged.
[[nodiscard]] inline Result judge(std::size_t solver, std::size_t index, const Problem& problem, double rtol,
                                  const Answer& answer) {
  Result result{solver, index, rtol, -1};
  if (!answer) return result;
  result.share = problem.error(*answer) / (problem.kappa * rtol);
  if (problem.conserved.size() > 0 && answer->allFinite()) {
    result.drift = std::abs(problem.conserved.dot(*answer - problem.start)) / problem.conserved.dot(problem.start);
    result.roundings = result.drift / problem.rounding_of_conserved();
    result.least = std::min(0.0, answer->minCoeff() / problem.start.maxCoeff());
  }
  return result;
}

}  // namespace truth
