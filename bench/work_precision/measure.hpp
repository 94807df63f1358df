/// @file
/// Runs, timed; what they reached; and the time to reach an error.
#pragma once

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "../equal_error.hpp"
#include "table.hpp"

namespace work_precision {

/// Of this thread: what else runs on the machine does not count.
[[nodiscard]] inline double now() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Options {
  std::string method, library, out = "out";  // only what has this text in its name
  int rounds = 5;
  double longest = 0.2;    ///< [s] finer rungs of a ladder are left out after a good run that took longer
  double shortest = 2e-3;  ///< [s] of one measurement: shorter runs are repeated within it
  double tightest = 0;     ///< of rtol
  bool films = true, half_decades = true;

  /// Enough to see that everything works.
  void be_quick() { rounds = 1, longest = 0.03, shortest = 2e-4, tightest = 1e-9, films = half_decades = false; }
};

/// One rung of a method's ladder.
struct Point {
  double parameter = 0;
  Answer answer{};
  double error = std::numeric_limits<double>::infinity();     ///< at the end
  double largest = std::numeric_limits<double>::quiet_NaN();  ///< over the times of the film
  int repeats = 1;
  std::vector<double> times{};

  [[nodiscard]] bool succeeded() const { return answer.y.size() > 0; }
  [[nodiscard]] bool is_timed() const { return error < 0.3; }
  [[nodiscard]] double seconds() const { return times.empty() ? 0 : times[times.size() / 2]; }
};

struct Measured {
  Table table;
  std::vector<std::vector<Point>> points;  ///< of each method
};

/// Answers first: every run once, its errors found. Then all that are right to a digit take turns on the clock.
[[nodiscard]] inline Measured measure(Table table, const Options& options) {
  Measured measured{std::move(table), {}};
  const Table& problem = measured.table;
  const std::vector<double> times = problem.times();
  const bool films = options.films && problem.truth;
  const Eigen::MatrixXd truth = films ? problem.truth(times) : Eigen::MatrixXd{};
  const auto largest_error = [&](const Film& film) {
    double largest = 0;
    for (Eigen::Index k = 0; k < truth.cols(); ++k)
      largest = std::max(largest, problem.error(film.y.col(k), truth.col(k)));
    return largest;
  };
  for (const Method& method : problem.methods) {
    std::vector<Point>& points = measured.points.emplace_back();
    if (method.name.find(options.method) == std::string::npos ||
        method.library.find(options.library) == std::string::npos)
      continue;
    double spent = 0;
    for (const double parameter : method.ladder) {
      if (method.parameter == "rtol" && parameter < 0.99 * options.tightest) break;
      if (method.parameter == "rtol" && !options.half_decades &&
          std::abs(std::remainder(std::log10(parameter), 1)) > 0.1)
        continue;
      Point& point = points.emplace_back();
      point.parameter = parameter;
      const double start = now();
      point.answer = method.run(parameter, nullptr);
      const double took = now() - start;
      if (point.succeeded()) point.error = problem.error(point.answer.y, problem.exact);
      point.repeats = std::max(1, static_cast<int>(options.shortest / std::max(took, 1e-7)));
      if (films && point.is_timed()) {
        Film film(times, problem.system.size());
        if (method.run(parameter, &film).y.size() > 0) point.largest = largest_error(film);
      }
      if (point.is_timed()) spent += took;  // a rung that fails slowly must not cost a method its others
      if ((took > options.longest && point.is_timed()) || spent > 8 * options.longest) break;
    }
  }
  for (int round = 0; round < options.rounds; ++round)
    for (std::size_t m = 0; m < measured.points.size(); ++m)
      for (Point& point : measured.points[m]) {
        if (!point.is_timed()) continue;
        const double start = now();
        for (int k = 0; k < point.repeats; ++k) static_cast<void>(problem.methods[m].run(point.parameter, nullptr));
        point.times.push_back((now() - start) / point.repeats);
      }
  for (auto& points : measured.points)
    for (Point& point : points) std::sort(point.times.begin(), point.times.end());
  return measured;
}

/// The least time in which a method's error is at most `wanted` (equal_error.hpp).
[[nodiscard]] inline std::optional<double> time_to(double wanted, const std::vector<Point>& points,
                                                   double Point::*error_of = &Point::error) {
  std::vector<std::pair<double, double>> runs;
  for (const Point& point : points)
    if (point.is_timed() && std::isfinite(point.*error_of)) runs.emplace_back(point.seconds(), point.*error_of);
  return bench::time_to_error(wanted, std::move(runs));
}

inline void write_header(std::ostream& csv) {
  csv.precision(6);
  csv << "problem,title,library,method,parameter,value,error,largest_error,seconds,steps,force_calls,jacobians,"
         "factorizations\n";
}
inline void write(std::ostream& csv, const Measured& measured) {
  for (std::size_t m = 0; m < measured.points.size(); ++m)
    for (const Point& point : measured.points[m]) {
      const Method& method = measured.table.methods[m];
      csv << measured.table.name << ",\"" << measured.table.title << "\"," << method.library << ",\"" << method.name
          << "\"," << method.parameter << ',' << point.parameter << ',' << point.error << ',' << point.largest << ','
          << point.seconds() << ',' << point.answer.steps << ',' << point.answer.force_calls << ','
          << point.answer.jacobians << ',' << point.answer.factorizations << '\n';
    }
  csv.flush();
}

/// A run that said "success" and is off by more than 100 κ rtol.
[[nodiscard]] inline bool is_wrong(const Point& point, double kappa) {
  return point.succeeded() && !(point.error <= 100 * kappa * point.parameter);
}

/// Who needs how long, and how often a success is none.
inline void print(const Measured& measured) {
  constexpr double wanted[] = {1e-3, 1e-6, 1e-9};
  const double kappa = measured.table.kappa;
  std::printf("  kappa = %.3g\n  %-28s %10s %10s %10s   %10s %10s %10s   %s\n", kappa, "us to an error of", "1e-3",
              "1e-6", "1e-9", "over time:", "1e-6", "1e-9", "wrong");
  for (std::size_t m = 0; m < measured.points.size(); ++m) {
    const auto& points = measured.points[m];
    if (points.empty()) continue;
    std::printf("  %-28s", measured.table.methods[m].name.c_str());
    for (auto error_of : {&Point::error, &Point::largest}) {
      for (const double error : wanted) {
        const auto time = time_to(error, points, error_of);
        if (time) std::printf(" %10.4g", 1e6 * *time);
        else std::printf(" %10s", "-");
      }
      std::printf("  ");
    }
    if (kappa > 0 && measured.table.methods[m].parameter == "rtol") {
      const auto wrong = [&](const Point& point) { return is_wrong(point, kappa); };
      std::printf(" %d", static_cast<int>(std::count_if(points.begin(), points.end(), wrong)));
      for (const Point& point : points)
        if (wrong(point)) std::printf(" (rtol %.0e: %.2g)", point.parameter, point.error);
    }
    std::printf("\n");
  }
  std::fflush(stdout);
}

}  // namespace work_precision
