/// @file
/// phistep with Jacobians by automatic differentiation.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/phistep.hpp"                 // states, steppers, schemes, the loop
#include "phistep/step/jacobian/autodiff.hpp"  // autodiff(f): ∂Ψ/∂y by Eigen's AutoDiffScalar
// IWYU pragma: end_exports
