/// @file
/// Everything.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/advise.hpp"     // which scheme to take
#include "phistep/autodiff.hpp"   // Jacobians by automatic differentiation
#include "phistep/automatic.hpp"  // the loop without a stepper
#include "phistep/battery.hpp"    // is a scheme, a state, a law of your own right?
#include "phistep/fields.hpp"     // vectors over ranks
#include "phistep/in_place.hpp"   // your own arrays
#include "phistep/io.hpp"         // files
#include "phistep/krylov.hpp"     // iterative linear solvers
#include "phistep/particles.hpp"  // many particles
#include "phistep/phistep.hpp"    // states, steppers, schemes, the loop
#include "phistep/preflight.hpp"  // is this Δt stable and accurate?
#include "phistep/sparse.hpp"     // sparse matrices
// IWYU pragma: end_exports
