/// @file
/// Run time against error, problem by problem: phistep's schemes and their rivals.
///     bench_work_precision [--problem NAME] [--method TEXT] [--library NAME] [--out DIR] [--rounds N] [--quick] [--ends]
///                          [--list] [--commit TEXT] | --conditioning
///
/// CPU time of the thread, set-up included; the runs of a problem take turns, and the median of the rounds counts. Errors: at
/// the end time, and the largest over 100 log-spaced times, which a second run of the same settings finds, untimed: it
/// interpolates there, or stops there where a library can't. Answers come first: a run that is right to less than a digit
/// is not timed. Writes DIR/work_precision.csv, of which plot.py makes the pictures, and DIR/work_precision.md, the summary.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "measure.hpp"
#include "summary.hpp"
#include "table.hpp"

namespace {
using namespace work_precision;

struct Entry {
  const char* name;
  Table (*make)();
};
constexpr Entry problems[] = {{"robertson", robertson},
                              {"robertson_late", robertson_late},
                              {"van_der_pol", van_der_pol},
                              {"hires", hires},
                              {"oregonator", oregonator},
                              {"pollution", pollution},
                              {"e5", e5},
                              {"e5_late", e5_late},
                              {"ring_modulator", ring_modulator},
                              {"beam", beam},
                              {"cusp", cusp},
                              {"plate", plate},
                              {"kepler", kepler},
                              {"pleiades", pleiades},
                              {"outer_solar_system", outer_solar_system},
                              {"medical_akzo", medical_akzo},
                              {"brusselator_1d", brusselator_1d},
                              {"heat_2d", heat_2d},
                              {"spring_network", spring_network}};

void add_rivals([[maybe_unused]] Table& table) {
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
  cvode(table);
  arkode(table);
#endif
#ifdef BENCH_HAS_ODEINT
  odeint(table);
#endif
#ifdef BENCH_HAS_GSL
  gsl(table);
#endif
#ifdef BENCH_HAS_PETSC
  petsc(table);
#endif
}

void say_who_is_missing() {
#ifndef BENCH_HAS_SUNDIALS_SOLVERS
  std::printf(
      "no CVODE, no ARKODE: SUNDIALS with KLU was not found (apt install libsundials-dev libsuitesparse-dev)\n");
#endif
#ifndef BENCH_HAS_ODEINT
  std::printf("no Odeint: Boost was not found (apt install libboost-dev)\n");
#endif
#ifndef BENCH_HAS_GSL
  std::printf("no GSL: it was not found (apt install libgsl-dev)\n");
#endif
#ifndef BENCH_HAS_PETSC
  std::printf("no PETSc: it was not found (apt install petsc-dev)\n");
#endif
}

/// How well the extended-precision solution agrees with the stored answer: both stand on their own.
double check_truth(const Table& table) {
  if (!table.truth) return 0;
  const Eigen::MatrixXd film = table.truth(table.times());
  double largest = 0;
  for (Eigen::Index k = 0; k < table.exact.size(); ++k)
    largest = std::max(
        largest, std::abs(film(k, film.cols() - 1) - table.exact[k]) / (std::abs(table.exact[k]) + table.system.a));
  return largest;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  std::string only, commit = "unknown commit";
  bool conditioning = false;
  for (int i = 1; i < argc; ++i) {
    const auto is = [&](const char* name) { return std::strcmp(argv[i], name) == 0 && i + 1 < argc; };
    if (is("--problem")) only = argv[++i];
    else if (is("--method")) options.method = argv[++i];
    else if (is("--library")) options.library = argv[++i];
    else if (is("--out")) options.out = argv[++i];
    else if (is("--rounds")) options.rounds = std::max(1, std::atoi(argv[++i]));
    else if (is("--commit")) commit = argv[++i];
    else if (std::strcmp(argv[i], "--quick") == 0) options.be_quick();
    else if (std::strcmp(argv[i], "--ends") == 0) options.films = false;
    else if (std::strcmp(argv[i], "--conditioning") == 0) conditioning = true;
    else {
      std::printf(
          "bench_work_precision [--problem NAME] [--method TEXT] [--library NAME] [--out DIR] [--rounds N] [--quick] "
          "[--ends] "
          "[--commit TEXT] | --conditioning\nproblems:");
      for (const Entry& entry : problems) std::printf(" %s", entry.name);
      std::printf("\n");
      return std::strcmp(argv[i], "--list") == 0 ? 0 : 1;
    }
  }

  std::filesystem::create_directories(options.out);
  std::ofstream csv(options.out + "/work_precision.csv");
  write_header(csv);
  std::printf("%s\n", versions().c_str());
  say_who_is_missing();
  std::vector<Measured> all;
  bool any = false;
  for (const Entry& entry : problems) {
    if (!only.empty() && only != entry.name) continue;
    any = true;
    Table table = entry.make();
    add_rivals(table);
    std::printf("\n%s\n", table.title.c_str());
    if (conditioning) {
      if (table.conditioning) std::printf("  kappa = %.3g, stored: %.3g\n", table.conditioning(), table.kappa);
      std::fflush(stdout);
      continue;
    }
    if (options.films && table.truth)
      std::printf("  the solution over time agrees with the stored answer to %.1e\n", check_truth(table));
    Measured measured = measure(std::move(table), options);
    write(csv, measured);
    print(measured);
    all.push_back(std::move(measured));
  }
  if (!any) {
    std::printf("no problem of that name; --list names them\n");
    return 1;
  }
  if (conditioning) return 0;
  const std::string summary = markdown(all, commit);
  std::ofstream(options.out + "/work_precision.md") << summary;
  std::printf("\n%s\n%s/work_precision.csv, %s/work_precision.md\n", summary.c_str(), options.out.c_str(),
              options.out.c_str());
  return 0;
}
