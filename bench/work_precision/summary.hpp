/// @file
/// The summary in Markdown: the time to an error, ratios, geometric means, and how often a success is none.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "measure.hpp"

#ifndef BENCH_FLAGS
#define BENCH_FLAGS "unknown flags"
#endif
#ifndef BENCH_RIVALS
#define BENCH_RIVALS "no rivals"
#endif

namespace work_precision {

[[nodiscard]] inline std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

[[nodiscard]] inline std::string versions() {
  std::ostringstream text;
#ifdef __clang__
  text << "clang " << __clang_version__;
#else
  text << "g++ " << __VERSION__;
#endif
  text << ", " << BENCH_FLAGS << "; Eigen " << EIGEN_WORLD_VERSION << '.' << EIGEN_MAJOR_VERSION << '.'
       << EIGEN_MINOR_VERSION << "; " << BENCH_RIVALS << "; " << processor();
  return text.str();
}

/// The quickest of some methods to an error, and its name.
struct Best {
  double seconds = 0;
  std::string name;
  [[nodiscard]] explicit operator bool() const { return seconds > 0; }
};
[[nodiscard]] inline Best best(const Measured& measured, double wanted, auto&& is_meant) {
  Best best;
  for (std::size_t m = 0; m < measured.points.size(); ++m) {
    const Method& method = measured.table.methods[m];
    if (!is_meant(method)) continue;
    const auto time = time_to(wanted, measured.points[m]);
    if (time && (!best || *time < best.seconds)) best = {*time, method.name};
  }
  return best;
}

[[nodiscard]] inline std::string formatted(double x) {
  char text[32];
  std::snprintf(text, sizeof text, x < 99.5 ? "%.3g" : "%.0f", x);
  return text;
}

/// Runs that said "success" with an error of more than 100 κ rtol, of all successes.
struct Share {
  int bad = 0, all = 0;
};
[[nodiscard]] inline Share untold_failures(const std::vector<Measured>& all, auto&& is_meant) {
  Share share;
  for (const Measured& measured : all) {
    if (measured.table.kappa <= 0) continue;
    for (std::size_t m = 0; m < measured.points.size(); ++m) {
      const Method& method = measured.table.methods[m];
      if (method.parameter != "rtol" || !is_meant(method)) continue;
      for (const Point& point : measured.points[m])
        if (point.succeeded()) {
          ++share.all;
          share.bad += is_wrong(point, measured.table.kappa);
        }
    }
  }
  return share;
}

[[nodiscard]] inline std::string markdown(const std::vector<Measured>& all, const std::string& commit) {
  const auto ours = [](const Method& method) { return method.library == "phistep"; };
  const auto rival = [](const Method& method) { return method.library != "phistep"; };
  const auto of_cvode = [](const Method& method) { return method.library == "CVODE"; };
  constexpr double wanted[] = {1e-3, 1e-6, 1e-9};
  const auto by = [](double ratio) { return formatted(ratio) + " ×"; };
  std::ostringstream text;
  text << "| CPU time, set-up included, to an error of | 1e-3 | 1e-6 | 1e-9 |\n|---|---|---|---|\n";
  struct Mean {
    double sum = 0;
    int count = 0;
    void add(double ratio) { sum += std::log(ratio), ++count; }
    [[nodiscard]] std::string text() const {
      return count ? formatted(std::exp(sum / count)) + " × (" + std::to_string(count) + ")" : std::string("–");
    }
  };
  Mean to_rival[2][3], to_cvode[2][3];  // of the small stiff problems, of the others
  for (const Measured& measured : all) {
    const std::size_t kind = measured.table.system.shape == Shape::dense ? 0 : 1;
    text << "| " << measured.table.title;
    for (std::size_t k = 0; k < 3; ++k) {
      const Best us = best(measured, wanted[k], ours), they = best(measured, wanted[k], rival),
                 cvode = best(measured, wanted[k], of_cvode);
      text << " | ";
      if (us) text << "**" << formatted(1e6 * us.seconds) << " µs** " << us.name;
      else text << "–";
      if (they)
        text << "; " << (us ? by(they.seconds / us.seconds) : formatted(1e6 * they.seconds) + " µs") << ' '
             << they.name;
      if (us && they) to_rival[kind][k].add(they.seconds / us.seconds);
      if (us && cvode) {
        text << "; " << by(cvode.seconds / us.seconds) << " CVODE";
        to_cvode[kind][k].add(cvode.seconds / us.seconds);
      }
    }
    text << " |\n";
  }
  const char* const kinds[] = {"stiff, few unknowns", "the others"};
  for (std::size_t kind = 0; kind < 2; ++kind) {
    text << "| geometric mean, " << kinds[kind];
    for (std::size_t k = 0; k < 3; ++k)
      text << " | best rival " << to_rival[kind][k].text() << ", CVODE " << to_cvode[kind][k].text();
    text << " |\n";
  }
  text << "\nEach cell: phistep's quickest scheme, the quickest of all rivals, CVODE's quickest (as multiples of "
          "phistep's "
          "time); – where no run is that accurate. Means: in brackets of how many problems.\n\n";
  const Share we = untold_failures(all, ours), they = untold_failures(all, of_cvode);
  const auto percent = [](const Share& share) {
    return share.all ? formatted(100.0 * share.bad / share.all) + " % of " + std::to_string(share.all)
                     : std::string("–");
  };
  text << "Successes with an error of more than 100 κ rtol, rtol = 1e-1 … 1e-13: phistep " << percent(we) << ", CVODE "
       << percent(they) << ".\n\n";
  char date[16] = "";
  const std::time_t seconds = std::time(nullptr);
  std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&seconds));
  text << "Measured " << date << " at " << commit << ": " << versions() << ".\n";
  return text.str();
}

}  // namespace work_precision
