/// @file
/// The loop without a stepper: the scheme is chosen, and changed where stiffness comes or goes.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/run/choice/automatic_stepper.hpp"  // integrate(y, force, {t0, t1}, tolerance{…}, observers…)
// IWYU pragma: end_exports
