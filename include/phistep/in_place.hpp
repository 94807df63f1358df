/// @file
/// phistep in an existing code: its own arrays, stepped in place under its own force routine.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/embed/in_place.hpp"  // MotionInPlace{r, v, f}, VectorInPlace{y, rate}
#include "phistep/embed/places.hpp"    // places(…): where a code keeps its particles' vectors
#include "phistep/phistep.hpp"         // states, steppers, schemes, the loop
// IWYU pragma: end_exports
