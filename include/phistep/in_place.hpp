/// @file
/// phistep in an existing code: its own arrays, stepped in place under its own force routine.
#pragma once

// IWYU pragma: begin_exports

#include "phistep/embed/in_place.hpp"
#include "phistep/embed/places.hpp"
#include "phistep/phistep.hpp"
// IWYU pragma: end_exports
