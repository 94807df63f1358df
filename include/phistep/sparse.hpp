/// @file
/// phistep with sparse Jacobians, mass matrices and solvers.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/core/version.hpp"  // first: it refuses what would break the others

#include "phistep/linear/sparse_mass.hpp"
#include "phistep/phistep.hpp"
#include "phistep/resolve/sparse_system.hpp"
#include "phistep/resolve/symmetric_sparse_system.hpp"
// IWYU pragma: end_exports
