/// @file
/// phistep with sparse Jacobians, mass matrices and solvers.
#pragma once

// IWYU pragma: begin_exports

#include "phistep/choice/field_matrix.hpp"
#include "phistep/linear/sparse_mass.hpp"
#include "phistep/matrix/sparse/factor_cost.hpp"
#include "phistep/matrix/sparse/sparse_lane_system.hpp"
#include "phistep/matrix/sparse/sparse_system.hpp"
#include "phistep/matrix/sparse/symmetric_sparse_system.hpp"
#include "phistep/phistep.hpp"
// IWYU pragma: end_exports
