/// @file
/// phistep with iterative linear solvers that need no matrix.
#pragma once

// IWYU pragma: begin_exports

#include "phistep/jacobian/product.hpp"
#include "phistep/krylov/preconditioned_system.hpp"
#include "phistep/krylov/product_system.hpp"
#include "phistep/phistep.hpp"
#include "phistep/solve/tangent_product.hpp"
// IWYU pragma: end_exports
