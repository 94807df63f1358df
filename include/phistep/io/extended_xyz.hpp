/// @file
/// Frames in the extended XYZ format, which OVITO, ASE and others open.
#pragma once

#include <Eigen/Core>

#include <limits>
#include <ostream>
#include <stdexcept>
#include <string_view>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Appends one frame: positions and, where given, velocities, both dim × N with dim ≤ 3 (missing coordinates are 0).
/// @throws std::invalid_argument where the shapes differ or dim > 3; std::runtime_error where the stream fails.
template <class Positions, class Velocities>
void write_extended_xyz(std::ostream& out, double time, const Eigen::DenseBase<Positions>& r,
                        const Eigen::DenseBase<Velocities>& v, std::string_view species = "X") {
  if (r.rows() > 3 || r.rows() != v.rows() || r.cols() != v.cols())
    throw std::invalid_argument(
        "phistep: write_extended_xyz needs positions and velocities of one shape, dim x N with dim <= 3");
  const auto precision = out.precision(std::numeric_limits<float>::max_digits10);
  out << r.cols() << "\nProperties=species:S:1:pos:R:3:velo:R:3 Time=" << time << '\n';
  const auto write = [&out](const auto& x, Eigen::Index j) {
    for (Eigen::Index i = 0; i < 3; ++i) out << ' ' << (i < x.rows() ? static_cast<double>(x.derived()(i, j)) : 0.0);
  };
  for (Eigen::Index j = 0; j < r.cols(); ++j) {
    out << species;
    write(r, j);
    write(v, j);
    out << '\n';
  }
  out.precision(precision);
  if (!out) throw std::runtime_error("phistep: writing an extended XYZ frame failed");
}

}  // namespace phistep::inline PHISTEP_ABI
