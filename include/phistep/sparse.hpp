/// @file
/// phistep with sparse Jacobians, mass matrices and solvers.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/phistep.hpp"
#include "phistep/resolve/sparse_system.hpp"
#include "phistep/linear/sparse_mass.hpp"
// IWYU pragma: end_exports
