/// @file
/// How stiff a problem is, as the beginning of a run has found it.
#pragma once

#include <cstdint>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// What the first steps of an automatic run found.
struct Stiffness {
  bool known = false;
  bool is_stiff = false;   ///< stability limits explicit steps, or would from the first on
  double rate = 0;         ///< [1/time] |λ|max of ∂y'/∂y where it was looked at last
  double dt = 0;           ///< [time] of the steps there
  double turns = 0;        ///< rate times the whole span
  std::int64_t steps = 0;  ///< done to find it out
  double covered = 0;      ///< share of the span that they covered
};

}  // namespace phistep::inline PHISTEP_ABI
