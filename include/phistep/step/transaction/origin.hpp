/// @file
/// What a caller of a step knows of the state that it hands over.
#pragma once

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Whether the state is known to be what the last step left.
enum class Origin {
  unknown,        ///< not known: it is checked
  rest_unedited,  ///< known of the particles outside the active set (base/state/active_set.hpp)
  unedited,       ///< the caller owns the loop
};

}}  // namespace phistep::PHISTEP_ABI
