/// @file
/// phistep with sparse Jacobians, mass matrices and solvers.
#pragma once

// IWYU pragma: begin_exports

#include "phistep/linear/lanes/sparse_lane_system.hpp"
#include "phistep/linear/sparse/factor_cost.hpp"
#include "phistep/linear/sparse/sparse_mass.hpp"
#include "phistep/linear/sparse/sparse_system.hpp"
#include "phistep/linear/sparse/symmetric_sparse_system.hpp"
#include "phistep/phistep.hpp"
#include "phistep/run/choice/field_matrix.hpp"
// IWYU pragma: end_exports
