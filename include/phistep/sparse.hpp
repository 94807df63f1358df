/// @file
/// phistep with sparse Jacobians, mass matrices and solvers.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/linear/sparse/factor_cost.hpp"    // what a factorization costs, from the pattern
#include "phistep/linear/sparse/sparse_mass.hpp"    // mass(M), capacity(C) with a sparse matrix
#include "phistep/linear/sparse/sparse_system.hpp"  // the step's matrix, sparse: LU; symmetric ones: Cholesky; radau's
#include "phistep/phistep.hpp"                      // states, steppers, schemes, the loop
#include "phistep/run/choice/field_matrix.hpp"      // automatic: factorize or iterate?
// IWYU pragma: end_exports
