/// @file
/// Many particles: states with masses, radii, spins; what stands on neighbour lists.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/force/pairs.hpp"
#include "phistep/phistep.hpp"
#include "phistep/state/box.hpp"
#include "phistep/state/particles.hpp"
#include "phistep/stepper/sleeping.hpp"
// IWYU pragma: end_exports
