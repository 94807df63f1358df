/// @file
/// Work against precision: how long a method takes to reach how small an error. Each problem is a table of methods, each
/// method a ladder of runs by one parameter, rtol or Δt. C++17, like all that Odeint's file sees.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "system.hpp"

namespace work_precision {

/// What a run reached, and what it took.
struct Answer {
  Eigen::VectorXd y{};  ///< at the end time; empty where the run failed
  std::int64_t steps = 0, force_calls = 0, jacobians = 0, factorizations = 0;
};

/// What the states were at given times: asked for in a second run, which nobody times.
struct Film {
  std::vector<double> times;  ///< ascending, the last is the end of the run
  Eigen::MatrixXd y;          ///< one column a time

  Film(std::vector<double> when, Eigen::Index n)
      : times{std::move(when)},
        y{Eigen::MatrixXd::Constant(n, static_cast<Eigen::Index>(times.size()),
                                    std::numeric_limits<double>::quiet_NaN())} {}
  void put(std::size_t k, const double* now) {
    y.col(static_cast<Eigen::Index>(k)) = Eigen::Map<const Eigen::VectorXd>(now, y.rows());
  }
};

/// One method on one problem. Each call of `run` is a run from nothing: set-up, memory and all. Given a film, it fills it.
struct Method {
  std::string library, name;
  std::string parameter;       ///< what the ladder is of: "dt" or "rtol"
  std::vector<double> ladder;  ///< from coarse to fine
  std::function<Answer(double, Film*)> run;
};

/// A problem: its answer, and who tries to find it.
struct Table {
  std::string name;
  std::string title;
  Eigen::VectorXd exact;  ///< at the end
  System system;
  double kappa = 0;    ///< by how much it magnifies a small error; 0: not known
  double decades = 6;  ///< the log-spaced times reach from end·10^−decades to the end
  std::function<Eigen::MatrixXd(const std::vector<double>&)> truth{};  ///< `exact`, one column a time
  std::vector<Eigen::Index> samples{};     ///< where `exact` and `truth` hold these components only
  std::function<double()> conditioning{};  ///< measures κ, which takes a while
  std::vector<Method> methods{};

  /// max |y_i − exact_i| / (|exact_i| + a); infinite where there is no answer or one that isn't finite
  [[nodiscard]] double error(const Eigen::Ref<const Eigen::VectorXd>& y,
                             const Eigen::Ref<const Eigen::VectorXd>& right) const {
    double largest = 0;
    for (Eigen::Index k = 0; k < right.size(); ++k) {
      const Eigen::Index i = samples.empty() ? k : samples[static_cast<std::size_t>(k)];
      if (i >= y.size() || !std::isfinite(y[i])) return std::numeric_limits<double>::infinity();
      largest = std::max(largest, std::abs(y[i] - right[k]) / (std::abs(right[k]) + system.a));
    }
    return largest;
  }
  /// n times from end·10^−decades to the end, evenly by their logarithms
  [[nodiscard]] std::vector<double> times(int n = 100) const {
    std::vector<double> t;
    for (int k = 0; k < n; ++k) t.push_back(system.end() * std::pow(10.0, -decades * (n - 1 - k) / (n - 1)));
    t.back() = system.end();
    return t;
  }
  void add(const std::string& library, const std::string& method, std::vector<double> ladder,
           std::function<Answer(double, Film*)> run) {
    methods.push_back({library, library + ' ' + method, "rtol", std::move(ladder), std::move(run)});
  }
};

/// 10^from … 10^to by factors of √10 (the tolerances are the same for everybody).
[[nodiscard]] inline std::vector<double> tolerances(double from = -1, double to = -13) {
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

// One file a problem …
[[nodiscard]] Table robertson();
[[nodiscard]] Table robertson_late();
[[nodiscard]] Table van_der_pol();
[[nodiscard]] Table hires();
[[nodiscard]] Table oregonator();
[[nodiscard]] Table pollution();
[[nodiscard]] Table e5();
[[nodiscard]] Table e5_late();
[[nodiscard]] Table ring_modulator();
[[nodiscard]] Table beam();
[[nodiscard]] Table cusp();
[[nodiscard]] Table plate();
[[nodiscard]] Table kepler();
[[nodiscard]] Table pleiades();
[[nodiscard]] Table outer_solar_system();
[[nodiscard]] Table medical_akzo();
[[nodiscard]] Table brusselator_1d();
[[nodiscard]] Table heat_2d();
[[nodiscard]] Table spring_network();

// … and one a rival. Each adds its methods to a problem, as many as make sense there.
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
void cvode(Table& table);
void arkode(Table& table);
#endif
#ifdef BENCH_HAS_ODEINT
void odeint(Table& table);
#endif
#ifdef BENCH_HAS_GSL
void gsl(Table& table);
#endif
#ifdef BENCH_HAS_PETSC
void petsc(Table& table);
#endif

}  // namespace work_precision
