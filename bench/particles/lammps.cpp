#include "lammps.hpp"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "process.hpp"

namespace bench {
namespace {
/// The number that follows `label`, wherever that is; 0 where it isn't.
double number_after(const std::string& text, const std::string& label, std::size_t from = 0) {
  const std::size_t at = text.find(label, from);
  return at == std::string::npos ? 0 : std::strtod(text.c_str() + at + label.size(), nullptr);
}

/// "Pair    | 0.87     | …": the first number of a row of the timing breakdown.
double breakdown(const std::string& text, const std::string& section) {
  const std::size_t at = text.find("\n" + section);
  const std::size_t bar = at == std::string::npos ? at : text.find('|', at);
  return bar == std::string::npos ? 0 : std::strtod(text.c_str() + bar + 1, nullptr);
}

std::vector<std::vector<std::string>> thermo_lines(const std::string& text) {
  std::vector<std::vector<std::string>> lines;
  std::istringstream stream(text);
  bool inside = false;
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::vector<std::string> columns;
    for (std::string word; words >> word;) columns.push_back(word);
    if (columns.empty()) continue;
    if (columns[0] == "Loop") inside = false;
    if (inside) lines.push_back(columns);
    if (columns[0] == "Step") inside = true;
  }
  return lines;
}
}  // namespace

std::optional<std::string> Lammps::version() const {
  const Output output = run_program(quoted(options_.lammps) + " -h");
  const std::size_t at = output.text.find("Simulator - ");
  if (output.status != 0 || at == std::string::npos) {
    std::printf("  no LAMMPS: '%s' does not run (Debian, Ubuntu: apt install lammps; or --lammps PATH)\n",
                options_.lammps.c_str());
    return std::nullopt;
  }
  return output.text.substr(at + 12, output.text.find('\n', at) - at - 12);
}

LammpsRun Lammps::run(const std::string& deck, const std::vector<std::pair<std::string, std::string>>& variables,
                      bool opt, int processes) const {
  std::string command = "OMP_NUM_THREADS=1 ";
  if (processes > 1) command += "mpirun --allow-run-as-root --oversubscribe -np " + std::to_string(processes) + " ";
  command += quoted(options_.lammps) + " -log none -in " + quoted(deck) + (opt ? " -sf opt" : "");
  for (const auto& [name, value] : variables) command += " -var " + name + " " + quoted(value);
  const Output output = run_program(command);
  const std::string& text = output.text;
  const std::size_t loop = text.find("Loop time of ");
  if (output.status != 0 || loop == std::string::npos)
    throw std::runtime_error("LAMMPS failed: " + command + "\n" +
                             text.substr(text.size() > 800 ? text.size() - 800 : 0));
  LammpsRun run;
  const double wall = number_after(text, "Loop time of "), cpu = [&] {
    const std::size_t end = text.find("% CPU use"), start = text.rfind('\n', end);
    return end == std::string::npos ? 100.0 : std::strtod(text.c_str() + start + 1, nullptr);
  }();
  // Several processes wait for each other, which counts as use.
  run.seconds = processes > 1 ? wall : wall * std::min(cpu, 100.0) / 100;
  run.pair = breakdown(text, "Pair ");
  run.neighbor = breakdown(text, "Neigh ");
  run.steps = static_cast<long>(number_after(text, " procs for ", loop));
  run.atoms = static_cast<long>(number_after(text, " steps with ", loop));
  run.builds = static_cast<long>(number_after(text, "Neighbor list builds = "));
  run.megabytes = number_after(text, "memory allocation (min/avg/max) = ");
  run.thermo = thermo_lines(text);
  return run;
}

std::string write_deck(const Options& options, const std::string& name, const std::string& text) {
  const std::string path = options.out + "/" + name;
  std::ofstream file(path);
  file << text;
  if (!file) throw std::runtime_error("cannot write " + path);
  return path;
}

std::string as_printed(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.8g", value);
  return text;
}

}  // namespace bench
