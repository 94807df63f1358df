/// @file
/// The loop in your hands: one step of a run at a time.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/run/run.hpp"  // Run{stepper, state, {t0, t1}, control, observers…}: advance(), finish(), report()
// IWYU pragma: end_exports
