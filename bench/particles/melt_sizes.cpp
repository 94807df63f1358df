/// @file
/// The melt from a thousand atoms to a million: time an atom-step, which has to stay the same, and memory an atom.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>

#include "melt_lammps.hpp"
#include "melt_library.hpp"
#include "process.hpp"

namespace bench {
namespace {
constexpr double skin = 0.3;

using Melt = LibraryMelt<double, phistep::LennardJones>;
}  // namespace

void print_melt_memory(int cells) {
  const double before = resident_megabytes();
  auto scene = std::make_unique<const Scene>(melt_start(cells));
  Melt melt{*scene, {}, {.skin = skin}};
  scene.reset();
  melt.step(20);
  const double n = static_cast<double>(melt.state().size());
  std::printf("%.1f %.1f\n", 1e6 * (resident_megabytes() - before) / n,
              4 * static_cast<double>(melt.force().pairs_listed()) / n);
}

void melt_sizes(const Options& options, Table& table) {
  const Lammps lammps{options};
  const bool has_lammps = lammps.version().has_value();
  const int steps = 20;  // of the same part of the motion: lists are made equally often
  struct Size {
    int cells, repeats;
    Scene scene = melt_start(cells);
    std::string data{};
  };
  std::vector<Size> sizes;
  for (const auto& [cells, repeats] : {std::pair{6, 20}, {10, 5}, {20, 1}, {40, 1}, {63, 1}}) {
    if (options.is_short && cells > 10) break;
    sizes.push_back({cells, repeats});
  }
  double first = 0, first_lammps = 0;  // at 32,000 atoms
  for (Size& size : sizes) {
    const double n = static_cast<double>(size.scene.size());
    std::vector<Entrant> entrants{{"phistep", [&size] {
                                     double sum = 0;
                                     for (int k = 0; k < size.repeats; ++k)
                                       sum += time_melt(size.scene, steps, {.skin = skin});
                                     return sum / size.repeats;
                                   }}};
    size.data = options.out + "/melt_" + std::to_string(size.scene.size()) + ".data";
    std::optional<MeltDeck> deck;
    double megabytes = 0;
    if (has_lammps) {
      write_lammps(size.scene, size.data);
      deck.emplace(options, lammps, size.data, steps);
      entrants.push_back({"LAMMPS opt", [&deck, &megabytes] {
                            const LammpsRun run = deck->run(safe, skin, true);
                            megabytes = run.megabytes;
                            return run.seconds;
                          }});
    }
    take_turns(entrants, size.cells > 20 ? (options.rounds + 1) / 2 : options.rounds);
    const auto per_step = [&](std::size_t e) { return 1e9 * entrants[e].median() / (n * steps); };
    for (std::size_t e = 0; e < entrants.size(); ++e)
      table.add({"sizes", entrants[e].name, size.scene.size(), 1, "time", "ns an atom-step", per_step(e)});
    if (size.cells == 20) {
      first = per_step(0);
      if (has_lammps) first_lammps = per_step(1);
    }
    if (size.cells > 20) {
      table.add({"sizes", "phistep, time an atom-step", size.scene.size(), 1, "growth", "x that at 32,000",
                 per_step(0) / first});
      if (has_lammps)
        table.add({"sizes", "LAMMPS opt, time an atom-step", size.scene.size(), 1, "growth", "x that at 32,000",
                   per_step(1) / first_lammps});
    }
    // In a process of its own: what others freed is not counted as free.
    const Output output =
        run_program("OMP_NUM_THREADS=1 " + quoted(std::filesystem::read_symlink("/proc/self/exe").string()) +
                    " --melt-memory " + std::to_string(size.cells));
    char* rest = nullptr;
    const double bytes = std::strtod(output.text.c_str(), &rest), list = std::strtod(rest, nullptr);
    table.add({"sizes", "phistep, resident", size.scene.size(), 1, "memory", "bytes an atom", bytes});
    table.add({"sizes", "phistep, of which neighbours listed", size.scene.size(), 1, "list", "bytes an atom", list});
    if (has_lammps)
      table.add(
          {"sizes", "LAMMPS opt, as it reports", size.scene.size(), 1, "memory", "bytes an atom", 1e6 * megabytes / n});
    if (has_lammps) std::remove(size.data.c_str());
  }
}

}  // namespace bench
