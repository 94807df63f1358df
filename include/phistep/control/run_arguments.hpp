/// @file
/// What a run can be made of, and what is said of other arguments.
#pragma once

#include <type_traits>

#include "phistep/control/control_of.hpp"
#include "phistep/control/fixed_step.hpp"
#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Whether the stepper may have been made for a state of this type.
template <class Stepper, class S>
inline constexpr bool fits_state = true;
template <class Stepper, class S>
  requires requires { typename Stepper::StateType; }
inline constexpr bool fits_state<Stepper, S> = std::is_same_v<typename Stepper::StateType, S>;

/// The times of a run; of no state, to be refused later.
template <class S>
struct SpanOf {
  using type = TimeSpan<double>;
};
template <State S>
struct SpanOf<S> {
  using type = TimeSpan<ScalarOf<S>>;
};

template <class Stepper, class S, class Control>
concept CanRun = MutableState<S&> && ControlOf<Control, S> && fits_state<Stepper, S>;

/// Says why they can't.
template <class Stepper, class S, class Control>
struct RunRefusal {
  static_assert(StateRefusal<MutableState<S&>, S>::is_said);
  static constexpr bool has_control = !MutableState<S&> || ControlOf<Control, S>,
                        has_stepper = !MutableState<S&> || fits_state<Stepper, S>;
  static_assert(
      has_control,
      "phistep: say how dt is chosen: fixed(0.1) for steps of 0.1, tolerance{.rtol = 1e-6}, iteration_control{...} "
      "or smaller_of(...)");
  static_assert(has_stepper, "phistep: the stepper was made for a state of another type");
};

}  // namespace phistep::inline PHISTEP_ABI
