/// @file
/// phistep with Jacobians by automatic differentiation.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/jacobian/autodiff.hpp"
#include "phistep/phistep.hpp"
// IWYU pragma: end_exports
