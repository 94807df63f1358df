/// @file
/// States whose numbers the library never touches: vectors spread over ranks, or in a device's memory.
#pragma once

// IWYU pragma: begin_exports

#include "phistep/io/rank_checkpoint.hpp"
#include "phistep/phistep.hpp"
#include "phistep/solve/fields/field_fixed_point.hpp"
#include "phistep/solve/fields/field_linearisation.hpp"
#include "phistep/solve/fields/field_solver.hpp"
#include "phistep/state/array_field.hpp"
#include "phistep/state/field.hpp"
#include "phistep/state/ranks.hpp"
// IWYU pragma: end_exports
