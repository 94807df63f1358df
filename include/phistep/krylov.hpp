/// @file
/// phistep with iterative linear solvers that need no matrix.
#pragma once

// IWYU pragma: begin_exports

#include "phistep/linear/krylov/preconditioned_system.hpp"
#include "phistep/linear/krylov/product_system.hpp"
#include "phistep/linear/krylov/tangent_product.hpp"
#include "phistep/phistep.hpp"
#include "phistep/step/jacobian/product.hpp"
// IWYU pragma: end_exports
