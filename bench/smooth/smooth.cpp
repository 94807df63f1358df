/// @file
/// Run time against error on smooth problems: DETEST and six more. Times to an error of 1e-3, 1e-6, 1e-9 at the end of the run,
/// max |y_i − exact_i| / (|exact_i| + 1), interpolated along each method's ladder of tolerances (atol = rtol); medians of
/// several rounds, set-up included.
///
///     bench_smooth [--problem NAME] [--rounds N] [--quick] [--out DIR] [--commit TEXT]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "../work_precision/measure.hpp"
#include "../work_precision/summary.hpp"
#include "tables.hpp"

namespace {
using namespace work_precision;

constexpr double wanted[] = {1e-3, 1e-6, 1e-9};

bool is_ours(const Method& method) { return method.library == "phistep"; }
bool is_rival(const Method& method) { return !is_ours(method); }
/// Of schemes for any y' = f(y, t).
bool is_ours_in_general(const Method& method) {
  return is_ours(method) && method.name.find("RKN") == std::string::npos;
}

/// Ratios, their geometric mean and the least of them.
class Ratios {
 public:
  void add(double ratio, const std::string& where) {
    sum_ += std::log(ratio), ++count_;
    if (least_.empty() || ratio < worst_) worst_ = ratio, least_ = where;
    below_ += ratio < 0.95;
  }
  [[nodiscard]] std::string text() const {
    if (count_ == 0) return "–";
    return formatted(std::exp(sum_ / count_)) + " × (" + std::to_string(count_) + "), worst " + formatted(worst_) +
           " " + least_ + ", below 0.95: " + std::to_string(below_);
  }

 private:
  double sum_ = 0, worst_ = 0;
  int count_ = 0, below_ = 0;
  std::string least_;
};

template <class Rows>
void write_rows(std::string& text, const Rows& rows) {
  for (const auto& [name, ratios] : rows) {
    text += "| " + name;
    for (const Ratios& each : ratios) text += " | " + each.text();
    text += " |\n";
  }
}

std::string summary(const std::vector<Measured>& all, const std::string& commit) {
  std::string text = "| CPU time, set-up included, to an error of | 1e-3 | 1e-6 | 1e-9 |\n|---|---|---|---|\n";
  Ratios best_of_all[3], general[3];
  std::map<std::string, Ratios[3]> rivals, schemes;
  for (const Measured& measured : all) {
    text += "| " + measured.table.title;
    for (int k = 0; k < 3; ++k) {
      const Best us = best(measured, wanted[k], is_ours), they = best(measured, wanted[k], is_rival);
      const Best in_general = best(measured, wanted[k], is_ours_in_general);
      text += us ? " | **" + formatted(1e6 * us.seconds) + " µs** " + us.name : std::string(" | –");
      if (they) text += "; " + (us ? formatted(they.seconds / us.seconds) + " × " : std::string()) + they.name;
      if (us && they) best_of_all[k].add(they.seconds / us.seconds, measured.table.name);
      if (in_general && they) general[k].add(they.seconds / in_general.seconds, measured.table.name);
      for (const Method& method : measured.table.methods) {
        const Best one = best(measured, wanted[k], [&](const Method& other) { return &other == &method; });
        if (!one) continue;
        if (is_ours(method) && they) schemes[method.name][k].add(they.seconds / one.seconds, measured.table.name);
        if (is_rival(method) && us) rivals[method.name][k].add(one.seconds / us.seconds, measured.table.name);
      }
    }
    text += " |\n";
  }
  text += "| geometric mean, best rival / best of phistep";
  for (const Ratios& each : best_of_all) text += " | " + each.text();
  text += " |\n| the same without the Nyström pairs";
  for (const Ratios& each : general) text += " | " + each.text();
  text += " |\n\nEach cell: phistep's quickest scheme, and the quickest rival's time as a multiple of it.\n\n";
  text += "| a rival's time / best of phistep | 1e-3 | 1e-6 | 1e-9 |\n|---|---|---|---|\n";
  write_rows(text, rivals);
  text += "\n| best rival's time / that of | 1e-3 | 1e-6 | 1e-9 |\n|---|---|---|---|\n";
  write_rows(text, schemes);
  return text + "\nAt " + commit + ": " + versions() + ".\n";
}

void add_rivals(Table& table) {
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
  cvode(table);
  arkode(table);
#endif
#ifdef BENCH_HAS_ODEINT
  smooth::odeint(table);
#endif
#ifdef BENCH_HAS_GSL
  gsl(table);
#endif
  static_cast<void>(smooth::numbalsoda(table));
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  options.films = false;
  std::string only, commit = "unknown commit";
  for (int i = 1; i < argc; ++i) {
    const auto is = [&](const char* name) { return std::strcmp(argv[i], name) == 0 && i + 1 < argc; };
    if (is("--problem")) only = argv[++i];
    else if (is("--method")) options.method = argv[++i];
    else if (is("--library")) options.library = argv[++i];
    else if (is("--rounds")) options.rounds = std::max(1, std::atoi(argv[++i]));
    else if (is("--out")) options.out = argv[++i];
    else if (is("--commit")) commit = argv[++i];
    else if (std::strcmp(argv[i], "--quick") == 0) options.be_quick();
    else {
      std::printf(
          "bench_smooth [--problem NAME] [--method TEXT] [--library NAME] [--rounds N] [--quick] [--out DIR] "
          "[--commit TEXT]\n");
      return 1;
    }
  }
  std::filesystem::create_directories(options.out);
  std::ofstream csv(options.out + "/smooth.csv");
  write_header(csv);
  std::printf("%s\n", versions().c_str());
  std::vector<Measured> all;
  for (const auto group : {smooth::single_equations, smooth::small_systems, smooth::moderate_systems, smooth::orbits,
                           smooth::second_order, smooth::others})
    for (Table& table : group()) {
      if (!only.empty() && only != table.name) continue;
      add_rivals(table);
      std::printf("\n%s\n", table.title.c_str());
      all.push_back(measure(std::move(table), options));
      write(csv, all.back());
      print(all.back());
    }
  if (all.empty()) {
    std::printf("no problem of that name\n");
    return 1;
  }
  const std::string text = summary(all, commit);
  std::ofstream(options.out + "/smooth.md") << text;
  std::printf("\n%s", text.c_str());
  return 0;
}
