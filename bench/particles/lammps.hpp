/// @file
/// LAMMPS as a process: a deck is written, the program is run on it, what it printed is read.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rows.hpp"

namespace bench {

struct LammpsRun {
  double seconds = 0;  ///< "Loop time" times the share of a CPU that it had: LAMMPS counts wall time
  double pair = 0;     ///< of which pair forces [s of wall time]
  double neighbor = 0;
  long steps = 0, atoms = 0, builds = 0;
  double megabytes = 0;                          ///< "Per MPI rank memory allocation"
  std::vector<std::vector<std::string>> thermo;  ///< its lines, the digits as printed
};

class Lammps {
 public:
  explicit Lammps(const Options& options) : options_{options} {}
  /// Its version; nothing, and a line that says so, where it isn't there.
  [[nodiscard]] std::optional<std::string> version() const;
  /// @param deck       input file
  /// @param variables  -var NAME VALUE, and -sf SUFFIX
  /// @param processes  through mpirun if more than one
  /// @throws std::runtime_error with the end of what it printed, where it failed
  [[nodiscard]] LammpsRun run(const std::string& deck,
                              const std::vector<std::pair<std::string, std::string>>& variables, bool opt = false,
                              int processes = 1) const;

 private:
  const Options& options_;
};

/// Writes a deck into the output folder and returns its path.
[[nodiscard]] std::string write_deck(const Options& options, const std::string& name, const std::string& text);

/// `value` in as many significant digits as LAMMPS printed (%.8g), and the like of its own.
[[nodiscard]] std::string as_printed(double value);

}  // namespace bench
