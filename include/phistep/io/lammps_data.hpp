/// @file
/// LAMMPS data files: `read_data` there, particles here.
///
///     Particles<double, 3> melt = read_lammps_data("melt.data").atoms;
///     auto data = read_lammps_data<Particles<double, 3, Spin>>("chute.data", {.style = "sphere"});
///     data.atoms, data.bonds, data.type_mass, …
///
/// Atom styles atomic, charge, sphere, bond (angle, molecular) and full. Source: docs.lammps.org/read_data.html. Types and
/// bond types are those of the file less 1, units are the file's. A compressed file: `zcat file.data.gz | program`, and
/// read_lammps_data(std::cin).
#pragma once

#include <cstdint>
#include <fstream>
#include <istream>
#include <stdexcept>
#include <string>
#include <utility>

#include "phistep/core/version.hpp"
#include "phistep/io/lammps_parser.hpp"
#include "phistep/particles/particles.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a LAMMPS data file holds: particles, box, bonds, masses of types.
/// @param name  of the stream, for errors
/// @throws std::runtime_error that names the line, where the text isn't a LAMMPS data file of a known style
template <class P = Particles<double, 3>>
[[nodiscard]] LammpsData<P> read_lammps_data(std::istream& in, const LammpsOptions& options = {},
                                             std::string name = "LAMMPS data") {
  return LammpsParser<P>{in, std::move(name), options}.read();
}
/// The same from the file of this name.
/// @throws std::runtime_error where it cannot be opened, or its text is wrong
template <class P = Particles<double, 3>>
[[nodiscard]] LammpsData<P> read_lammps_data(const std::string& path, const LammpsOptions& options = {}) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("phistep: cannot open " + path);
  return read_lammps_data<P>(in, options, path);
}

}}  // namespace phistep::PHISTEP_ABI
