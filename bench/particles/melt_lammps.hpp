/// @file
/// The melt as LAMMPS' bench/in.lj has it, from a data file, and when it makes its lists.
#pragma once

#include <string>

#include "lammps.hpp"

namespace bench {

/// neigh_modify every … delay … check …
struct Policy {
  const char *every, *delay, *check;
};
constexpr Policy safe{"1", "0", "yes"}, unchecked{"20", "0", "no"}, by_default{"1", "10", "yes"};

class MeltDeck {
 public:
  MeltDeck(const Options& options, const Lammps& lammps, std::string data, int steps)
      : lammps_{lammps}, data_{std::move(data)}, steps_{steps}, path_{write_deck(options, "melt.in", R"(units lj
atom_style atomic
read_data ${data}
pair_style lj/cut 2.5
pair_coeff 1 1 1.0 1.0 2.5
neighbor ${skin} bin
neigh_modify delay ${delay} every ${every} check ${check}
fix 1 all nve
timestep 0.005
thermo ${steps}
run ${steps}
)")} {}
  [[nodiscard]] LammpsRun run(const Policy& policy, double skin, bool opt, int processes = 1) const {
    return lammps_.run(path_,
                       {{"data", data_},
                        {"skin", as_text(skin)},
                        {"every", policy.every},
                        {"delay", policy.delay},
                        {"check", policy.check},
                        {"steps", std::to_string(steps_)}},
                       opt, processes);
  }

 private:
  const Lammps& lammps_;
  std::string data_;
  int steps_;
  std::string path_;
};

}  // namespace bench
