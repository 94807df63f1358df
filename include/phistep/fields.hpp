/// @file
/// States whose numbers the library never touches: vectors spread over ranks, or in a device's memory.
#pragma once

// IWYU pragma: begin_exports

#include "phistep/base/state/field.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/embed/array_field.hpp"
#include "phistep/embed/field_fixed_point.hpp"
#include "phistep/embed/field_linearisation.hpp"
#include "phistep/embed/field_solver.hpp"
#include "phistep/io/rank_checkpoint.hpp"
#include "phistep/phistep.hpp"
// IWYU pragma: end_exports
