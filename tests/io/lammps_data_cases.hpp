// What lammps_data.test.cpp and lammps_data.full.cpp share.
#pragma once

#include <phistep/io/lammps_data.hpp>

#include <Eigen/Core>

#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace lammps_data_cases {
inline auto read(const std::string& text, const LammpsOptions& options = {}) {
  std::istringstream in(text);
  return read_lammps_data(in, options, "melt.data");
}
template <class P>
auto read_as(const std::string& text, const LammpsOptions& options = {}) {
  std::istringstream in(text);
  return read_lammps_data<P>(in, options, "melt.data");
}

inline const std::string atomic =
    "LAMMPS data file via write_data\n\n3 atoms\n2 atom types\n\n-1 2.5 xlo xhi\n0 4 ylo yhi # a comment\n0 5 zlo "
    "zhi\n\n"
    "Masses\n\n1 39.95\n2 83.8  # Kr\n\nPair Coeffs # lj/cut\n\n1 1 1\n2 1 1\n\n"
    "Atoms # atomic\n\n7 2 0.5 1 1.5 0 1 -2\n2 1 1e-1 +2 3 0 0 0\n3 1 1 1 1 0 0 0\n\n"
    "Velocities\n\n3 0 0 0\n2 -1 2 -3\n7 .5 .25 .125\n";
}  // namespace lammps_data_cases
