/// @file
/// States whose numbers the library never touches: vectors spread over ranks, or in a device's memory.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/base/state/field.hpp"           // Field: a block of such numbers
#include "phistep/base/state/ranks.hpp"           // one decision for all ranks
#include "phistep/embed/array_field.hpp"          // the operations of a field in arrays
#include "phistep/embed/field_linearization.hpp"  // Newton's iteration, and what solves its linear equations
#include "phistep/io/rank_checkpoint.hpp"         // a checkpoint over ranks
#include "phistep/phistep.hpp"                    // states, steppers, schemes, the loop
// IWYU pragma: end_exports
