/// @file
/// The loop: a stepper taken from t0 to exactly t1.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/run/run.hpp"  // integrate(stepper, state, {t0, t1}, control, observers…); Run: the same, step by step
// IWYU pragma: end_exports
