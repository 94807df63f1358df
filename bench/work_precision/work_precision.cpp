/// @file
/// Time against error, problem by problem: phistep's schemes, CVODE, ARKODE.
///     bench_work_precision [--problem NAME] [--method TEXT] [--error E] [--out DIR] [--rounds N] [--list]
///
/// CPU time of the thread, set-up included; the runs of a problem take turns, and the median of the rounds counts. A run
/// whose error at the end time is absurd (none of its digits is right) is named and not timed. Writes
/// DIR/work_precision.csv, of which plot.py makes the pictures, and prints who reaches an error of 1e-3 (or --error) when.
#include <phistep/phistep.hpp>

#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#ifdef BENCH_HAS_SUNDIALS_SOLVERS
#include <sundials/sundials_config.h>
#endif

#include "table.hpp"

#ifndef BENCH_FLAGS
#define BENCH_FLAGS "unknown flags"
#endif

namespace {
using namespace work_precision;

/// Of this thread: what else runs on the machine does not count.
double now() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Options {
  std::string problem, method, out = "out";  // only what is so named, or has this text in its name
  int rounds = 5;
  double error = 1e-3, longest = 0.5;  ///< [s] finer rungs of a ladder are left out after a run that took longer
};

/// One run of the ladder, timed.
struct Point {
  const Method* method;
  double parameter, error;
  Answer answer;
  int repeats = 1;  // runs within one measurement: short ones are below the clock's grain
  std::vector<double> times{};
  [[nodiscard]] double median() {
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
  }
};

/// Answers first: every run once, its error found. Those that are right to less than a digit aren't timed.
std::vector<Point> answers(const Table& table, const Options& options) {
  std::vector<Point> points;
  for (const Method& method : table.methods) {
    if (method.name.find(options.method) == std::string::npos) continue;
    for (const double parameter : method.ladder) {
      const double start = now();
      Point point{&method, parameter, 0, method.run(parameter)};
      const double took = now() - start;
      point.error = table.error(point.answer);
      if (point.error < 0.3) {
        point.repeats = std::max(1, static_cast<int>(2e-3 / std::max(took, 1e-7)));
        points.push_back(std::move(point));
      } else {
        std::printf("  %-34s %4s = %.1e: %s, not timed\n", method.name.c_str(), method.parameter.c_str(), parameter,
                    point.answer.y.size() == 0 ? "failed" : ("error " + std::to_string(point.error)).c_str());
      }
      if (took > options.longest && point.error < 0.3) break;
    }
  }
  return points;
}

void time_in_turns(std::vector<Point>& points, int rounds) {
  for (int round = 0; round < rounds; ++round)
    for (Point& point : points) {
      const double start = now();
      for (int k = 0; k < point.repeats; ++k) static_cast<void>(point.method->run(point.parameter));
      point.times.push_back((now() - start) / point.repeats);
    }
}

/// The least time in which a method's error is at most `wanted`: on the front of its runs that no other beats in both, and
/// between two of them by a straight line through the logarithms. Nothing where it isn't reached.
std::optional<double> time_to(double wanted, const Method& method, std::vector<Point>& points) {
  std::vector<std::pair<double, double>> front;  // (time, error)
  for (Point& point : points)
    if (point.method == &method) front.emplace_back(point.median(), std::max(point.error, 1e-16));
  std::sort(front.begin(), front.end());
  double before_time = 0, before_error = 0;
  for (const auto& [time, error] : front) {
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

std::string versions() {
  std::ostringstream text;
#ifdef __clang__
  text << "clang " << __clang_version__;
#else
  text << "g++ " << __VERSION__;
#endif
  text << "; " << BENCH_FLAGS << "; " << Eigen::SimdInstructionSetsInUse() << "; Eigen " << EIGEN_WORLD_VERSION << '.'
       << EIGEN_MAJOR_VERSION << '.' << EIGEN_MINOR_VERSION;
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
  text << "; SUNDIALS " << SUNDIALS_VERSION;
#else
  text << "; no SUNDIALS";
#endif
  return text.str();
}

void write(std::ostream& csv, const Table& table, std::vector<Point>& points) {
  for (Point& point : points)
    csv << table.name << ',' << '"' << point.method->name << '"' << ',' << point.method->parameter << ','
        << point.parameter << ',' << point.error << ',' << point.median() << ',' << point.answer.steps << ','
        << point.answer.force_calls << ',' << point.answer.jacobians << ',' << point.answer.factorizations << ",\""
        << versions() << "\"\n";
}

bool starts_with(const std::string& text, const char* start) { return text.rfind(start, 0) == 0; }

void summarise(const Table& table, std::vector<Point>& points, double wanted) {
  struct Row {
    std::string name;
    double time;
  };
  std::vector<Row> rows;
  double cvode = 0, arkode = 0;  // the best of each
  for (const Method& method : table.methods) {
    const auto time = time_to(wanted, method, points);
    if (!time) continue;
    rows.push_back({method.name, *time});
    for (auto [name, best] : {std::pair{"CVODE", &cvode}, std::pair{"ARKODE", &arkode}})
      if (starts_with(method.name, name) && (*best == 0 || *time < *best)) *best = *time;
  }
  std::sort(rows.begin(), rows.end(), [](const Row& x, const Row& y) { return x.time < y.time; });
  std::printf("  to an error of %.0e:%22s us   CVODE's/it  ARKODE's/it\n", wanted, "");
  for (const Row& row : rows) {
    std::printf("    %-38s %10.1f", row.name.c_str(), 1e6 * row.time);
    for (const double best : {cvode, arkode}) {
      if (best > 0) std::printf("   %9.2f", best / row.time);
      else std::printf("   %9s", "-");
    }
    std::printf("\n");
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  struct Entry {
    const char* name;
    Table (*make)();
  };
  const Entry entries[] = {{"hires", hires},
                           {"robertson", robertson},
                           {"van_der_pol", van_der_pol},
                           {"kepler", kepler},
                           {"brusselator_1d", brusselator_1d},
                           {"heat_2d", heat_2d},
                           {"spring_network", spring_network}};
  for (int i = 1; i < argc; ++i) {
    const auto is = [&](const char* name) { return std::strcmp(argv[i], name) == 0 && i + 1 < argc; };
    if (is("--problem")) options.problem = argv[++i];
    else if (is("--method")) options.method = argv[++i];
    else if (is("--out")) options.out = argv[++i];
    else if (is("--rounds")) options.rounds = std::max(1, std::atoi(argv[++i]));
    else if (is("--error")) options.error = std::atof(argv[++i]);
    else {
      std::printf(
          "bench_work_precision [--problem NAME] [--method TEXT] [--error E] [--out DIR] [--rounds N]; problems:");
      for (const Entry& entry : entries) std::printf(" %s", entry.name);
      std::printf("\n");
      return std::strcmp(argv[i], "--list") == 0 ? 0 : 1;
    }
  }

  std::filesystem::create_directories(options.out);
  const std::string path = options.out + "/work_precision.csv";
  std::ofstream csv(path);
  csv.precision(6);
  csv << "problem,method,parameter,value,error,seconds,steps,force_calls,jacobians,factorizations,compiled_with\n";
  std::printf("%s\n", versions().c_str());
  bool any = false;
  for (const Entry& entry : entries) {
    if (!options.problem.empty() && options.problem != entry.name) continue;
    any = true;
    const Table table = entry.make();
    std::printf("\n%s\n", table.title.c_str());
    std::vector<Point> points = answers(table, options);
    time_in_turns(points, options.rounds);
    write(csv, table, points);
    summarise(table, points, options.error);
  }
  if (!any) std::printf("no problem of that name; --list names them\n");
  else std::printf("\n%s\n", path.c_str());
  return any ? 0 : 1;
}
