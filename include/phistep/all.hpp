/// @file
/// Everything.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/advise.hpp"
#include "phistep/autodiff.hpp"
#include "phistep/automatic.hpp"
#include "phistep/fields.hpp"
#include "phistep/in_place.hpp"
#include "phistep/io.hpp"
#include "phistep/krylov.hpp"
#include "phistep/particles.hpp"
#include "phistep/phistep.hpp"
#include "phistep/preflight.hpp"
#include "phistep/sparse.hpp"
// IWYU pragma: end_exports
