/// @file
/// What a run can be made of, the pace that its control asks for, and what is said of other arguments.
#pragma once

#include <type_traits>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/control/fixed_step.hpp"
#include "phistep/run/control/iteration_control.hpp"
#include "phistep/run/control/pace.hpp"
#include "phistep/run/errors/tolerance.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

}}  // namespace phistep::PHISTEP_ABI
