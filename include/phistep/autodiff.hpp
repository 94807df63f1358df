/// @file
/// phistep with Jacobians by automatic differentiation.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/core/version.hpp"  // first: it refuses what would break the others

#include "phistep/jacobian/autodiff.hpp"
#include "phistep/phistep.hpp"
// IWYU pragma: end_exports
