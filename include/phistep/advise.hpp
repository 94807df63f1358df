/// @file
/// Before the first step: which scheme to take, and why.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/study/advise.hpp"  // advise(state, force, {t0, t1}, tolerance{…}): the line of code to write
// IWYU pragma: end_exports
