/// @file
/// How a step or a run ended. Failures are values; nothing is accepted in silence.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// How a step or a run ended.
enum class Outcome : std::uint8_t {
  success,                ///< the step was done; the run has reached t1
  non_finite_state,       ///< the state given, or the state reached, holds a NaN or an infinity
  non_finite_force,       ///< Ψ does
  non_finite_jacobian,    ///< ∂Ψ/∂y does
  singular_matrix,        ///< M − γC − γ²K could not be factorized
  not_positive_definite,  ///< a symmetric solver met a matrix that is indefinite
  not_affine,             ///< a force promised to be affine isn't, or its Jacobian is wrong
  not_symmetric,          ///< a tangent promised to be symmetric isn't
  linear_solver_failed,   ///< an iterative or sparse solver gave up
  newton_diverged,        ///< the increments grew
  newton_stalled,         ///< the increments stopped falling before they were small
  iteration_diverged,     ///< the fixed-point iteration moved away from its solution
  iteration_stalled,      ///< it came nearer too slowly, or not at all
  error_too_large,        ///< the estimated error of the step exceeds what was asked for
  step_too_small,         ///< t + Δt = t, below 64 ulp(t) with events, or below the smallest step allowed
  too_many_steps,         ///< the run's step cap was reached
  invalid_step,           ///< Δt or t is not finite, or Δt = 0
  invalid_tolerance,      ///< rtol, atol or a bound on the step can't work
  stopped_by_observer,    ///< an observer asked for the end
  stopped_by_event,       ///< a terminal event occurred, or its handler asked for the end
  non_finite_event,       ///< an event's g is NaN or infinite
  events_accumulate,      ///< an event follows itself faster than time can tell (Zeno)
  wrong_jacobian,         ///< a Jacobian that was supplied, or its declared pattern, isn't the force's
  wrong_size,             ///< the force or its Jacobian returned another size than the state's
  inconsistent_start,     ///< the state given doesn't satisfy the algebraic equations
  exception_elsewhere,    ///< of a field spread over ranks: another rank's force or solver threw an exception
};

/// Whether a step or a part of it ended otherwise than well.
[[nodiscard]] constexpr bool failed(Outcome outcome) { return outcome != Outcome::success; }

namespace detail {
struct OutcomeText {
  Outcome outcome;
  const char *description, *advice;
  bool may_be_cured = false;
};
/// A row for each outcome, in their order.
struct OutcomeTexts {
  using enum Outcome;
  static constexpr OutcomeText rows[] = {
      {success, "success", ""},
      {non_finite_state, "the state is not finite",
       "check the initial state; if the run blew up, take a smaller dt or an implicit scheme (phi >= 1/2)", true},
      {non_finite_force, "the force is not finite",
       "check the force there for a division by zero, a root of a negative number, or a t that it says it doesn't use; "
       "a smaller dt may avoid it",
       true},
      {non_finite_jacobian, "the Jacobian is not finite",
       "check the Jacobian (check_jacobian), or let differences compute it", true},
      {singular_matrix, "the step's matrix is singular",
       "take a smaller dt: M - gamma C - gamma^2 K has no inverse at this one", true},
      {not_positive_definite, "the step's matrix is not positive definite",
       "use an LU solver, or a smaller dt: the tangent is indefinite here (a compressed spring, a friction term)",
       true},
      {not_affine, "a force promised to be affine is not, or its Jacobian is wrong",
       "drop affine(...) from the force, or check its Jacobian (check_jacobian)"},
      {not_symmetric, "a tangent promised to be symmetric is not",
       "drop symmetric(...) from the force (sliding friction is not), or correct its Jacobian"},
      {linear_solver_failed, "the linear solver failed",
       "loosen the iterative solver's tolerance, or use a direct solver", true},
      {newton_diverged, "Newton's iteration diverged",
       "take a smaller dt, or check the Jacobian (check_jacobian) and the force for jumps", true},
      {newton_stalled, "Newton's iteration stalled",
       "take a smaller dt, or check the Jacobian (check_jacobian) and the force for jumps", true},
      {iteration_diverged, "the fixed-point iteration diverged",
       "take a smaller dt (plain iteration needs phi dt omega < 1, or phi dt |dPsi/dy| < 1), or solve with newton()",
       true},
      {iteration_stalled, "the fixed-point iteration stalled",
       "take a smaller dt (plain iteration needs phi dt omega < 1, or phi dt |dPsi/dy| < 1), or solve with newton()",
       true},
      {error_too_large, "the step's estimated error is too large", "take a smaller dt"},
      {step_too_small,
       "the step is too small: t + dt = t, or less than 64 ulp of t where there are events, or below the smallest step "
       "allowed",
       "a jump or a singularity lies here, or the tolerance is below rounding: loosen it, locate the jump as an event, "
       "shift the origin of time, or use a wider scalar"},
      {too_many_steps, "too many steps", "raise max_steps, or take a larger dt"},
      {invalid_step, "t or dt is not a usable number",
       "dt must be finite and not 0, and not negative where the span runs forward; t must be finite"},
      {invalid_tolerance, "the tolerances or step bounds can't work",
       "rtol must lie between rounding and 1, atol must be finite and not negative, one per component or per block; 0 "
       "<= min_step <= max_step, max_step > 0, first_step >= 0, max_steps >= 0; of an iteration_control desired >= 1 "
       "and order > 0, of one alone first_step > 0"},
      {stopped_by_observer, "stopped by an observer", ""},
      {stopped_by_event, "stopped by an event", ""},
      {non_finite_event, "the function of an event is not finite",
       "check the event's g for a division by zero or a root of a negative number there"},
      {events_accumulate, "an event follows itself faster than time can tell",
       "let the handler end the run (return false) or switch to resting contact once the motion is slow enough"},
      {wrong_jacobian, "the Jacobian supplied, or the pattern declared for it, is not the force's",
       "check the Jacobian (check_jacobian) and the band or pattern, or let differences without a pattern compute it"},
      {wrong_size, "the force or its Jacobian has another size than the state",
       "let the force return as many rows and columns as the state (its velocities) has, its Jacobian one of each per "
       "unknown"},
      {inconsistent_start, "the state given does not satisfy the algebraic equations",
       "solve for the algebraic components first: make_consistent(stepper, state, t)"},
      {exception_elsewhere, "another rank threw an exception", "see what the rank says that threw it"},
  };

  [[nodiscard]] static constexpr OutcomeText of(Outcome outcome) {
    const auto k = static_cast<std::size_t>(outcome);
    return k < std::size(rows) ? rows[k] : OutcomeText{outcome, "unknown outcome", ""};
  }
};
}  // namespace detail

/// The outcome in a few words.
[[nodiscard]] constexpr const char* describe(Outcome outcome) { return detail::OutcomeTexts::of(outcome).description; }
/// What to try next.
[[nodiscard]] constexpr const char* advise(Outcome outcome) { return detail::OutcomeTexts::of(outcome).advice; }
/// Whether a smaller step may succeed where one failed so, the state itself being finite.
[[nodiscard]] constexpr bool may_be_cured(Outcome outcome) { return detail::OutcomeTexts::of(outcome).may_be_cured; }

}}  // namespace phistep::PHISTEP_ABI
