/// @file
/// DETEST and other smooth problems as tables of methods. phistep's schemes are listed here, and nowhere else.
#pragma once

#include <vector>

#include "../work_precision/table.hpp"

namespace work_precision::smooth {

// One file a group of problems, each with phistep's rows …
[[nodiscard]] std::vector<Table> single_equations();
[[nodiscard]] std::vector<Table> small_systems();
[[nodiscard]] std::vector<Table> moderate_systems();
[[nodiscard]] std::vector<Table> orbits();
[[nodiscard]] std::vector<Table> second_order();
[[nodiscard]] std::vector<Table> others();

// … and one a rival.
#ifdef BENCH_HAS_ODEINT
void odeint(Table& table);
#endif
/// DOP853 and LSODA as the Python package numbalsoda has them compiled: its folder is named by the environment variable
/// NUMBALSODA. False where they are not found.
bool numbalsoda(Table& table);

}  // namespace work_precision::smooth
