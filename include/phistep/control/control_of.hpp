/// @file
/// What a run takes as its control, and the controller made of it.
#pragma once

#include "phistep/control/fixed_step.hpp"
#include "phistep/control/grid_pace.hpp"
#include "phistep/control/iteration_control.hpp"
#include "phistep/control/pace.hpp"
#include "phistep/control/tolerance.hpp"
#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The pace that a control asks for.
template <State S>
[[nodiscard]] GridPace<ScalarOf<S>> pace_of(const FixedStep& control) {
  return GridPace<ScalarOf<S>>{control};
}
template <State S>
[[nodiscard]] ErrorPace<PlainState<S>> pace_of(const tolerance& control) {
  return ErrorPace<PlainState<S>>{control};
}
template <State S>
[[nodiscard]] ErrorPace<PlainState<S>> pace_of(const SmallerOf& control) {
  return ErrorPace<PlainState<S>>{control};
}
template <State S>
[[nodiscard]] IterationPace<PlainState<S>> pace_of(const iteration_control& control) {
  return IterationPace<PlainState<S>>{control};
}

/// What a run takes as its control.
template <class Control, class S>
concept ControlOf = requires(const Control& control) {
  pace_of<S>(control);
};
}  // namespace phistep::inline PHISTEP_ABI
