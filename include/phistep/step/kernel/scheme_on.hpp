/// @file
/// What a scheme is: a text over an equation (step/kernel/equation.hpp), that is a class whose step(eq) is written in eq's words
/// (forward, resolve, …), so that the same lines serve plain and traced steps: `SchemeOn<Scheme, S>` for states of type S, with
///
///     template <class Rhs> static constexpr KernelNeeds needs;   what it asks of the kernel
///     SchemeOn(scheme, y)                                        y gives the sizes of what it keeps
///
/// and what the concept StepsOn lists: of that it inherits most from SchemeDefaults, where it keeps nothing from step to
/// step. One that tells of its steps' errors (`traces`) has
///
///     Outcome error(eq)          e in eq.trace.error, and slopes, of the traced step just taken
///     Outcome reach_end(eq)      a step within the tolerance ends where the next can start: Ψ is finite there
///
/// and may know more:
///
///     int error_order() const;   its estimate goes as this power of Δt, if not as that of order() + 1
///                                (or step() judges it, and sets trace.proposed)
#pragma once

#include <array>
#include <concepts>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/step/kernel/kernel.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A scheme's step on states of type S, specialized for each scheme, each in a header of its own (phistep.hpp includes all).
template <class Scheme, State S>
class SchemeOn {
  static_assert(!sizeof(Scheme), "phistep: this is no scheme, or the header that defines it is not included");
};

/// Base of a scheme that keeps nothing from step to step.
struct SchemeDefaults {
  /// How far a scheme has come since its start: part of a checkpoint.
  struct Progress {};
  [[nodiscard]] static Progress progress() { return {}; }
  static void resume(Progress) {}
  static void resize(const auto& /*y*/) {}
  static void archive(auto& /*ar*/) {}
  static void forget() {}    ///< nothing carried from step to step may be trusted
  static void reset() {}     ///< the next step is the first
  static void accepted() {}  ///< the step just advanced has become the state
  /// Whether the Ψ that the last resolve has left may serve the next step: only if an error in it dies out.
  [[nodiscard]] static bool leaves_force() { return true; }
  [[nodiscard]] static Outcome error(auto& /*eq*/) { return Outcome::success; }  ///< step() leaves it
  /// Ψ exists at the end of the traced step just taken.
  [[nodiscard]] static Outcome reach_end(auto& eq) { return eq.reach_end(); }
  /// `interpolate` has what it needs of the step done last; it may call the force for that.
  [[nodiscard]] static bool know_inside(auto& /*rhs*/, auto /*dt*/, const auto& /*y0*/) { return true; }
  static constexpr bool traces = false, interpolates = false, is_sure_inside = false, reads_weights = false;
  static constexpr bool has_inner_steps = false;  ///< its slopes don't tell what is inside, nor whether Δt may change
  static constexpr bool looks_back =
      false;  ///< it takes more than Ψ from the step before: nothing moves the state between
  [[nodiscard]] static bool takes_singular_mass() { return false; }  ///< M y' = Ψ with a singular M: never asks for M⁻¹
  static constexpr std::array<double, 2> doubtful_at = usually_doubtful;
};

/// A step by a scheme's text, and Ψ at its end where that serves the next.
template <class Eq>
[[nodiscard, gnu::always_inline]] inline Outcome take_step(auto& text, Eq& eq) {
  const Outcome outcome = text.step(eq);
  if constexpr (Eq::Kernel::carries)
    if (!failed(outcome) && text.leaves_force()) eq.leave_force();
  return outcome;
}

/// A scheme's text takes steps of states of type S, and has what its own facts promise: that it takes traced steps, too, and
/// tells of their slopes and error; that it knows the solution inside the step that it did last.
template <class Text, class S, class Kernel>
concept StepsOn = requires(Text& text, typename Kernel::Equation& eq, const PlainState<S>& y,
                           typename Text::Progress progress) {
  { text.step(eq) } -> std::same_as<Outcome>;  // fills eq.next, leaves eq.y
  { text.order() } -> std::convertible_to<int>;
  { text.progress() } -> std::convertible_to<typename Text::Progress>;
  text.resume(progress);
  text.resize(y);
  text.accepted();
  text.forget();
  text.reset();
  requires !Text::traces || requires(typename Kernel::Traced & traced) {
    { text.step(traced) } -> std::same_as<Outcome>;
    { text.error(traced) } -> std::same_as<Outcome>;
    { text.reach_end(traced) } -> std::same_as<Outcome>;
    { text.estimates(traced.trace) } -> std::convertible_to<bool>;  // whether it knows an error, given this past
  };
  requires !Text::interpolates || requires(const Text& known, ScalarOf<S> x, PlainState<S>& out) {
    known.interpolate(x, x, y, y, out);                       // out = y(t + x Δt), 0 < x < 1, of the step from y to y
    { Text::doubtful_at[0] } -> std::convertible_to<double>;  // where that is worst, to be checked by real steps
  };
};

}}  // namespace phistep::PHISTEP_ABI
