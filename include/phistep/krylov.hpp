/// @file
/// phistep with iterative linear solvers that need no matrix.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/core/version.hpp"  // first: it refuses what would break the others

#include "phistep/jacobian/product.hpp"
#include "phistep/phistep.hpp"
#include "phistep/resolve/krylov_system.hpp"
#include "phistep/stepper/tangent_product.hpp"
// IWYU pragma: end_exports
