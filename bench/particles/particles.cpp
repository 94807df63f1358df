/// @file
/// Many particles: phistep beside LAMMPS, run as a process on the same start, and beside loops written by hand. Answers
/// are compared before anything is timed. CPU time of the thread (wall where several work, LAMMPS: its "Loop time" times
/// its share of a CPU); runs take turns, and the median of the rounds counts.
///     bench_particles [--rows melt,springs,…] [--rounds N] [--short] [--out DIR] [--threads N] [--lammps PROGRAM]
///                     [--chute FILE] [--list]
/// Writes DIR/particles.csv, of which plot.py makes pictures. For the baseline instruction set, which is what Debian's
/// LAMMPS is compiled for, a second tree: cmake -B build/baseline -DPHISTEP_BENCH_NATIVE=OFF. Rows of two threads mean
/// something only where both cores are free: --threads 1 leaves them out.
#include <Eigen/Core>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>

#include "rows.hpp"

#ifndef BENCH_FLAGS
#define BENCH_FLAGS "unknown flags"
#endif

namespace {
struct Row {
  const char* name;
  const char* title;
  void (*run)(const bench::Options&, bench::Table&);
};
const Row rows[] = {
    {"melt", "Lennard-Jones melt, velocity Verlet, beside LAMMPS", bench::melt},
    {"sizes", "The melt from 1,000 to 1,000,000 atoms: time and memory an atom", bench::melt_sizes},
    {"mixture", "Kob and Andersen's mixture: a cutoff for each pair of types, beside LAMMPS", bench::mixture},
    {"grains", "Grains down a chute, contacts with history, beside LAMMPS", bench::grains},
    {"gravity", "All pairs, softened gravity, beside kernels by hand", bench::gravity},
    {"springs", "Spring sheet, symplectic Euler, three orders of input", bench::springs},
    {"drift", "Argon: error and energy against time over a ladder of dt", bench::drift},
    {"skipping", "Grains at rest: sleeping on against off, heaps beside Bullet", bench::skipping},
    {"charged", "Charged Lennard-Jones drop: Coulomb of all pairs once in 8 inner steps", bench::charged},
    {"bonded", "Beam of bonded particles: implicit against explicit at equal error", bench::bonded},
};

std::string compiled_with() {
#ifdef __clang__
  const std::string compiler = std::string("clang ") + __clang_version__;
#else
  const std::string compiler = std::string("g++ ") + __VERSION__;
#endif
  return compiler + "; " + BENCH_FLAGS + "; " + Eigen::SimdInstructionSetsInUse();
}

bool contains(const std::string& list, const std::string& name) {
  return list.empty() || ("," + list + ",").find("," + name + ",") != std::string::npos;
}
}  // namespace

int main(int argc, char** argv) {
  bench::Options options;
  options.threads = std::min(2, bench::most_threads());
  for (int i = 1; i < argc; ++i) {
    const auto is = [&](const char* name) { return std::strcmp(argv[i], name) == 0 && i + 1 < argc; };
    if (is("--rows")) options.rows = argv[++i];
    else if (is("--out")) options.out = argv[++i];
    else if (is("--lammps")) options.lammps = argv[++i];
    else if (is("--chute")) options.chute = argv[++i];
    else if (is("--rounds")) options.rounds = std::max(1, std::atoi(argv[++i]));
    else if (is("--threads")) options.threads = std::max(1, std::atoi(argv[++i]));
    else if (is("--melt-memory")) {
      bench::print_melt_memory(std::atoi(argv[++i]));
      return 0;
    } else if (std::strcmp(argv[i], "--short") == 0) options.is_short = true;
    else {
      std::printf(
          "bench_particles [--rows A,B] [--rounds N] [--short] [--out DIR] [--threads N] [--lammps PROGRAM] "
          "[--chute FILE]; rows:\n");
      for (const Row& row : rows) std::printf("  %-10s %s\n", row.name, row.title);
      return std::strcmp(argv[i], "--list") == 0 ? 0 : 1;
    }
  }
  std::filesystem::create_directories(options.out);
  std::printf("%s\n", compiled_with().c_str());
  bench::Table table;
  bool all_right = true;
  for (const Row& row : rows) {
    if (!contains(options.rows, row.name)) continue;
    std::printf("\n%s: %s\n  %-52s %9s %2s\n", row.name, row.title, "", "particles", "th");
    try {
      row.run(options, table);
    } catch (const std::exception& error) {
      std::printf("  %s\n", error.what());
      all_right = false;
    }
  }
  const std::string path = options.out + "/particles.csv";
  table.write(path, compiled_with());
  std::printf("\n%s\n", path.c_str());
  return all_right ? 0 : 1;
}
