/// @file
/// What a run asks of any stepper, a user's own too: a step, a slope, and the way back to what it remembered of its history.
#pragma once

#include <concepts>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/run/control/run_clock.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/mass/mass.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A step without an estimate of its error.
template <class Stepper, class S, class Scalar>
StepReport do_step(Stepper& stepper, S& state, Scalar t, Scalar dt, [[maybe_unused]] Origin origin) {
  if constexpr (requires { stepper.step(state, t, dt, origin); }) return stepper.step(state, t, dt, origin);
  else return stepper.step(state, t, dt);
}

/// out = y' at (t, y) by a force call: success, non_finite_force or wrong_size.
template <State S, class Stepper>
[[nodiscard]] Outcome slope_of(Stepper& stepper, ScalarOf<S> t, const PlainState<S>& y, PlainState<S>& out) {
  static_assert(
      requires { stepper.slope(t, y, out); },
      "phistep: this stepper has no slope(t, y, out) (Sleeping hasn't): it takes fixed steps, without events and "
      "without "
      "samples inside of steps");
  try {
    return stepper.slope(t, y, out) ? Outcome::success : Outcome::non_finite_force;
  } catch (const WrongSize&) {
    if constexpr (!FieldState<S>)
      for_each_number([](auto, auto& x) { x = std::numeric_limits<ScalarOf<S>>::quiet_NaN(); }, Blocks<S>::all(out));
    return Outcome::wrong_size;
  }
}

/// What the force of a field, or its solver, has thrown on this rank: of a stepper, or of the one inside it.
template <class Stepper>
[[nodiscard]] HeldException& held_exception(Stepper& stepper) {
  return StepperInternals::at_work(
      stepper, [](auto& one) -> HeldException& { return *StepperInternals::kernel(one).rhs().held(); });
}

/// What such slopes at both ends of a step lack where M is singular: what M doesn't see moves from y0 to y1 along the chord.
template <State S, class Stepper>
void complete_slopes(const Stepper& stepper, const PlainState<S>& y0, const PlainState<S>& y1, ScalarOf<S> dt,
                     PlainState<S>& slope0, PlainState<S>& slope1) {
  StepperInternals::at_work(stepper, [&](auto& one) {
    const auto& rhs = StepperInternals::kernel(one).rhs();
    if constexpr (std::remove_cvref_t<decltype(rhs)>::may_be_singular)
      if (algebraic_component(rhs.masses())) {
        PlainState<S> chord = y0;
        assign<S>(chord, (in<S>(y1) - in<S>(y0)) / dt);
        keep_unseen(Blocks<S>::solved(chord), rhs.masses());
        add<S>(slope0, in<S>(chord));
        add<S>(slope1, in<S>(chord));
      }
  });
}

/// What runs under a tolerance without atol leave in a stepper for the next.
[[nodiscard]] decltype(auto) kept_sizes(auto& stepper) {
  return StepperInternals::at_work(
      stepper, [](auto& one) -> auto& { return StepperInternals::kept_sizes(one); });
}

/// A stepper that chooses its scheme, of which it is number active() that is at work: begin_run(…) → whether the run's first step
/// is to be proposed anew, for another scheme; choose(…), before each step, → [time] the longest step that its new scheme may
/// begin with, or nothing where it keeps its scheme.
template <class Stepper, class S, class Pace>
concept ChoosesScheme = requires(Stepper& stepper, S& state, const PlainState<S>& y, const RunClock<ScalarOf<S>>& clock,
                                 Pace& pace) {
  { stepper.begin_run(state, y, clock, pace) } -> std::same_as<bool>;
  { stepper.choose(state, y, clock, pace) } -> std::same_as<std::optional<double>>;
  { stepper.active() } -> std::same_as<int>;
};

template <class Stepper>
inline constexpr bool can_go_back = requires(Stepper& stepper) {
  stepper.restore(stepper.checkpoint());
};

/// A stepper around one that can go back, and can't itself: a step rejected would leave its history behind.
template <class Stepper>
concept HidesPast = !can_go_back<Stepper> && requires(Stepper & outer) {
  requires can_go_back<std::remove_reference_t<decltype(outer.stepper())>>;
};

/// The checkpoint of a stepper that can't go back.
struct NoPast {};
template <class Stepper>
[[nodiscard]] auto past_of(const Stepper& stepper) {
  if constexpr (can_go_back<Stepper>) return stepper.checkpoint();
  else return NoPast{};
}
template <class Stepper>
using Past = decltype(past_of(std::declval<const Stepper&>()));

/// Makes the stepper forget Ψ where it stands, and all else that it carried there, except its history.
template <class Stepper>
void forget_what_is_known(Stepper& stepper) {
  if constexpr (requires { StepperInternals::forget_known(stepper); }) StepperInternals::forget_known(stepper);
  else if constexpr (can_go_back<Stepper>) stepper.restore(stepper.checkpoint());
  else if constexpr (requires { stepper.stepper(); }) forget_what_is_known(stepper.stepper());
  else if constexpr (requires { stepper.reset(); }) stepper.reset();
}

/// Steps of this stepper may be undone.
template <class Stepper>
constexpr void require_past() {
  static_assert(
      !HidesPast<Stepper>,
      "phistep: events, samples and tolerances may undo a step: a stepper around a stepper then needs checkpoint() "
      "and restore(past) of the one inside (Sleeping has none: it takes fixed steps alone)");
}
/// The stepper's history is again `past`, or starts anew. A past that is moved from makes it allocate nothing.
template <class Stepper, class PastOfIt>
void go_back(Stepper& stepper, [[maybe_unused]] PastOfIt&& past) {
  require_past<Stepper>();
  if constexpr (can_go_back<Stepper>) stepper.restore(std::forward<PastOfIt>(past));
  else if constexpr (requires { stepper.reset(); }) stepper.reset();
}

}}  // namespace phistep::PHISTEP_ABI
