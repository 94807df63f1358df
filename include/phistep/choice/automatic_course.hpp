/// @file
/// What a stepper that chooses its scheme knows of its way so far.
#pragma once

#include <cstdint>

#include "phistep/choice/rate_look.hpp"
#include "phistep/choice/scheme_uses.hpp"
#include "phistep/choice/stiffness_watch.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What its checkpoint holds beside the scheme at work.
template <State Plain>
struct AutomaticCourse {
  StiffnessWatch watch;
  RateLook<Plain> look;
  bool is_bound;           ///< to the scheme at work, although or because it is stiff
  bool is_direct = false;  ///< Krylov iterations have failed: no more of them
  SchemeUses uses{};
  Statistics retired{};              ///< of the schemes before
  std::int64_t changes = 0;          ///< of the forces of these
  std::int64_t steps = 0, done = 0;  ///< steps seen, steps since
  void archive(auto& ar) {
    ar("watch", watch, "look", look, "uses", uses, "retired", retired, "steps", steps, "done", done, "changes", changes,
       "is_bound", is_bound, "is_direct", is_direct);
    ar.check(can_be_count(steps) && can_be_count(done));
  }
};

}}  // namespace phistep::PHISTEP_ABI
