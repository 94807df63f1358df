/// @file
/// How a run asks its observers.
#pragma once

#include <type_traits>

#include "phistep/core/version.hpp"
#include "phistep/observe/completed_step.hpp"
#include "phistep/observe/goes_on.hpp"

namespace phistep::inline PHISTEP_ABI {

/// An observer that looks at whole steps.
template <class Observer, class S>
inline constexpr bool observes_steps = std::is_invocable_v<Observer&, const CompletedStep<S>&>;

/// Shows (t, state) to one observer.
template <class Observer, class Scalar, class S>
[[nodiscard]] bool show(Observer& observer, Scalar t, S& state) {
  static_assert(!std::is_const_v<Observer> || std::is_invocable_v<Observer&, Scalar, S&>,
                "phistep: this observer changes as it observes, so it can't be const");
  static_assert(
      std::is_const_v<Observer> || std::is_invocable_v<Observer&, Scalar, S&>,
      "phistep: an observer must be callable as observer(t, state) or observer(step), returning nothing or false "
      "to stop");
  if constexpr (!std::is_invocable_v<Observer&, Scalar, S&>) return false;
  else return ask(observer, t, state);
}

}  // namespace phistep::inline PHISTEP_ABI
