/// @file
/// phistep with iterative linear solvers: with a preconditioner, or without a matrix.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/linear/krylov/preconditioned_system.hpp"  // newton<PreconditionedCg<P>>(), …Bicgstab, …Gmres
#include "phistep/linear/krylov/product_system.hpp"  // newton<MatrixFree<…>>(): products, a force's or by differences
#include "phistep/phistep.hpp"                       // states, steppers, schemes, the loop
#include "phistep/step/jacobian/analytic.hpp"        // apply_jacobian: ∂Ψ/∂y·x by the force
// IWYU pragma: end_exports
