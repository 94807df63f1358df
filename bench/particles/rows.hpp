/// @file
/// What the rows of bench_particles share: options, clocks, runs that take turns, and the table that they end in.
#pragma once

#include <time.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace bench {

struct Options {
  std::string rows;            ///< comma-separated names; empty: all
  std::string out = "out";     ///< where CSV, decks and starts are written
  std::string lammps = "lmp";  ///< the program
  std::string chute;           ///< LAMMPS' data.chute, plain or gzipped; it is not part of phistep
  int rounds = 5;              ///< repeats, of which the median counts
  int threads = 2;             ///< the most that are tried
  bool is_short = false;       ///< small scenes: does everything run?
};

/// The thread's own time where one thread works, so that what else runs on the machine does not count; the wall's where
/// several do.
class Stopwatch {
 public:
  explicit Stopwatch(int threads = 1) : threads_{threads} {}
  [[nodiscard]] double seconds() const { return now() - start_; }

 private:
  [[nodiscard]] double now() const {
    if (threads_ > 1) return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  int threads_;
  double start_ = now();
};

/// Somebody who does the work: returns the seconds that count.
struct Entrant {
  std::string name;
  std::function<double()> run;
  int threads = 1;
  std::vector<double> times{};
  [[nodiscard]] double median() const {
    std::vector<double> sorted = times;
    std::sort(sorted.begin(), sorted.end());
    return sorted.empty() ? 0 : sorted[sorted.size() / 2];
  }
};

inline void take_turns(std::vector<Entrant>& entrants, int rounds) {
  for (int round = 0; round < rounds; ++round)
    for (Entrant& entrant : entrants) entrant.times.push_back(entrant.run());
}

/// One number of the table and of the CSV.
struct Figure {
  std::string row, name;
  long particles = 0;
  int threads = 1;
  std::string quantity, unit;
  double value = 0;
};

/// Prints each figure when it is known, and writes all of them at the end.
class Table {
 public:
  void add(Figure figure);
  /// `work` units were done by each entrant: its rate, and its ratios to those named `against`.
  void rates(const std::string& row, long particles, double work, const std::string& unit,
             const std::vector<Entrant>& entrants, const std::vector<std::string>& against = {});
  void write(const std::string& path, const std::string& compiled_with) const;

 private:
  std::vector<Figure> figures_;
};

[[nodiscard]] std::string as_text(double value);  ///< %g

/// Megabytes that this process holds [MB].
[[nodiscard]] double resident_megabytes();

/// Threads that OpenMP starts from now on; 1 where it isn't compiled in.
void use_threads(int n);
[[nodiscard]] int most_threads();

// One file a row.
void melt(const Options& options, Table& table);
void melt_sizes(const Options& options, Table& table);
void mixture(const Options& options, Table& table);
void print_melt_memory(int cells);  ///< bytes an atom: all, and the list's; in a process of its own
void springs(const Options& options, Table& table);
void grains(const Options& options, Table& table);
void gravity(const Options& options, Table& table);
void drift(const Options& options, Table& table);
void skipping(const Options& options, Table& table);
void charged(const Options& options, Table& table);
void bonded(const Options& options, Table& table);

}  // namespace bench
