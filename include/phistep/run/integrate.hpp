/// @file
/// The loop: stepper × pace × observers, all the way.
#pragma once

#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include <type_traits>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/run/run.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Steps `state` from span.t0 to exactly span.t1, forward or backward.
/// @param control    fixed(dt), tolerance{.rtol = 1e-6, .atol = 1e-9}, iteration_control{…} or smaller_of(both)
/// @param observers  called at t0 and after every step as observer(t, state); one that returns false ends the run. An
///                   observer callable as observer(step) sees a CompletedStep instead, from the first step on; begin(t0,
///                   state), if it has that, comes before. at_times and sampled are called at given times, event at roots.
/// @return outcome, time reached, counts; on failure the state is that of the last good step
template <class Stepper, class S, class Control, class... Observers>
  requires(!State<Stepper>)
RunReport integrate(Stepper& stepper, S&& state, typename SpanOf<std::remove_reference_t<S>>::type span,
                    const Control& control, Observers&&... observers) {
  static_assert(StateRefusal<MutableState<S>, std::remove_reference_t<S>>::is_said);
  if constexpr (MutableState<S>)
    return Run<Stepper, std::remove_reference_t<S>, Control, Observers...>{stepper, state, span, control,
                                                                           std::forward<Observers>(observers)...}
        .finish();
  else return {};
}
/// No run: says which header runs without a stepper. (What that header offers is a better match.)
template <State S, class F, class Control, class... Observers>
RunReport integrate(S&, F&&, TimeSpan<std::type_identity_t<ScalarOf<S>>>, const Control&, Observers&&...) {
  static_assert(!sizeof(S),
                "phistep: integrate without a stepper chooses its scheme: it is in <phistep/automatic.hpp>");
  return {};
}
template <State S, class F, class Mass, class Control, class... Observers>
RunReport integrate(S& y, F&& force, const Mass&, TimeSpan<std::type_identity_t<ScalarOf<S>>> span,
                    const Control& control, Observers&&...) {
  return integrate(y, force, span, control);
}
/// No run: says how times are given.
template <class Stepper, class S, class T, class... Rest>
  requires std::is_arithmetic_v<T> RunReport integrate(Stepper&, S&&, T, Rest&&...) {
    static_assert(!std::is_arithmetic_v<T>,
                  "phistep: the times of a run go in braces: integrate(stepper, state, {t0, t1}, fixed(dt))");
    return {};
  }

}}  // namespace phistep::PHISTEP_ABI
