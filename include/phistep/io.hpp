/// @file
/// Files: what touches streams.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/io/checkpoint.hpp"    // save and load a run
#include "phistep/io/csv.hpp"           // tables
#include "phistep/io/extended_xyz.hpp"  // frames of particles, for OVITO and ASE
#include "phistep/io/vtk.hpp"           // particles, grids and meshes, for ParaView and PyVista
// IWYU pragma: end_exports
