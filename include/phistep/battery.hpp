/// @file
/// Is a scheme, a state, a pair law of one's own right? Reports, without a test framework.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/study/battery/battery_report.hpp"  // check_state(y): copies, NaN, failures; check_pair_law(law, nearest, cutoff)
#include "phistep/study/battery/check_scheme.hpp"  // check_scheme(scheme): order, failures, restarts, units, tolerance
#include "phistep/study/checks/check_force.hpp"    // check_force(force, y), check_jacobian(force, y)
// IWYU pragma: end_exports
