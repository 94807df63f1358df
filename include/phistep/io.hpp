/// @file
/// Files and progress: what touches streams.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/io/checkpoint.hpp"
#include "phistep/io/csv.hpp"
#include "phistep/io/extended_xyz.hpp"
#include "phistep/io/progress.hpp"
#include "phistep/io/vtk.hpp"
// IWYU pragma: end_exports
