/// @file
/// phistep with sparse Jacobians, mass matrices and solvers.
#pragma once

// IWYU pragma: begin_exports

#include "phistep/linear/sparse_mass.hpp"
#include "phistep/matrix/factor_cost.hpp"
#include "phistep/matrix/sparse_lane_system.hpp"
#include "phistep/matrix/sparse_system.hpp"
#include "phistep/matrix/symmetric_sparse_system.hpp"
#include "phistep/phistep.hpp"
#include "phistep/step/field_matrix.hpp"
// IWYU pragma: end_exports
