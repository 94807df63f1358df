/// @file
/// Before the first step: is this Δt stable and accurate?
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/study/preflight.hpp"  // preflight(stepper, state, dt): verdict, longest stable Δt, what limits it
// IWYU pragma: end_exports
