/// @file
/// How a step or a run ended. Failures are values; nothing is accepted in silence.
#pragma once

#include <cstdint>

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

/// The outcome in a few words.
[[nodiscard]] constexpr const char* describe(Outcome outcome) {
  switch (outcome) {
    case Outcome::success:
      return "success";
    case Outcome::non_finite_state:
      return "the state is not finite";
    case Outcome::non_finite_force:
      return "the force is not finite";
    case Outcome::non_finite_jacobian:
      return "the Jacobian is not finite";
    case Outcome::singular_matrix:
      return "the step's matrix is singular";
    case Outcome::not_positive_definite:
      return "the step's matrix is not positive definite";
    case Outcome::not_affine:
      return "a force promised to be affine is not, or its Jacobian is wrong";
    case Outcome::not_symmetric:
      return "a tangent promised to be symmetric is not";
    case Outcome::wrong_jacobian:
      return "the Jacobian supplied, or the pattern declared for it, is not the force's";
    case Outcome::linear_solver_failed:
      return "the linear solver failed";
    case Outcome::newton_diverged:
      return "Newton's iteration diverged";
    case Outcome::newton_stalled:
      return "Newton's iteration stalled";
    case Outcome::iteration_diverged:
      return "the fixed-point iteration diverged";
    case Outcome::iteration_stalled:
      return "the fixed-point iteration stalled";
    case Outcome::error_too_large:
      return "the step's estimated error is too large";
    case Outcome::step_too_small:
      return "the step is too small: t + dt = t, or less than 64 ulp of t where there are events, or below the "
             "smallest step allowed";
    case Outcome::too_many_steps:
      return "too many steps";
    case Outcome::invalid_step:
      return "t or dt is not a usable number";
    case Outcome::invalid_tolerance:
      return "the tolerances or step bounds can't work";
    case Outcome::stopped_by_observer:
      return "stopped by an observer";
    case Outcome::stopped_by_event:
      return "stopped by an event";
    case Outcome::non_finite_event:
      return "the function of an event is not finite";
    case Outcome::events_accumulate:
      return "an event follows itself faster than time can tell";
    case Outcome::wrong_size:
      return "the force or its Jacobian has another size than the state";
    case Outcome::inconsistent_start:
      return "the state given does not satisfy the algebraic equations";
    case Outcome::exception_elsewhere:
      return "another rank threw an exception";
  }
  return "unknown outcome";
}

/// What to try next.
[[nodiscard]] constexpr const char* advise(Outcome outcome) {
  switch (outcome) {
    case Outcome::success:
    case Outcome::stopped_by_observer:
    case Outcome::stopped_by_event:
      return "";
    case Outcome::non_finite_state:
      return "check the initial state; if the run blew up, take a smaller dt or an implicit scheme (phi >= 1/2)";
    case Outcome::non_finite_force:
      return "check the force for a division by zero or a root of a negative number there; a smaller dt may avoid it";
    case Outcome::non_finite_jacobian:
      return "check the Jacobian (check_jacobian), or let differences compute it";
    case Outcome::singular_matrix:
      return "take a smaller dt: M - gamma C - gamma^2 K has no inverse at this one";
    case Outcome::not_positive_definite:
      return "use an LU solver, or a smaller dt: the tangent is indefinite here (a compressed spring, a friction term)";
    case Outcome::not_affine:
      return "drop affine(...) from the force, or check its Jacobian (check_jacobian)";
    case Outcome::not_symmetric:
      return "drop symmetric(...) from the force (sliding friction is not), or correct its Jacobian";
    case Outcome::wrong_jacobian:
      return "check the Jacobian (check_jacobian) and the band or pattern, or let differences without a pattern "
             "compute it";
    case Outcome::linear_solver_failed:
      return "loosen the iterative solver's tolerance, or use a direct solver";
    case Outcome::newton_diverged:
    case Outcome::newton_stalled:
      return "take a smaller dt, or check the Jacobian (check_jacobian) and the force for jumps";
    case Outcome::iteration_diverged:
    case Outcome::iteration_stalled:
      return "take a smaller dt (plain iteration needs phi dt omega < 1, or phi dt |dPsi/dy| < 1), or solve with "
             "newton()";
    case Outcome::error_too_large:
      return "take a smaller dt";
    case Outcome::step_too_small:
      return "a jump or a singularity lies here, or the tolerance is below rounding: loosen it, locate the jump as an "
             "event, shift the origin of time, or use a wider scalar";
    case Outcome::too_many_steps:
      return "raise max_steps, or take a larger dt";
    case Outcome::invalid_tolerance:
      return "rtol must lie between rounding and 1, atol must be finite and not negative, one per component or per "
             "block; 0 <= min_step <= max_step, max_step > 0, first_step >= 0, max_steps >= 0; of an iteration_control "
             "desired >= 1 and order > 0, of one alone first_step > 0";
    case Outcome::invalid_step:
      return "dt must be finite and not 0, and not negative where the span runs forward; t must be finite";
    case Outcome::non_finite_event:
      return "check the event's g for a division by zero or a root of a negative number there";
    case Outcome::events_accumulate:
      return "let the handler end the run (return false) or switch to resting contact once the motion is slow enough";
    case Outcome::wrong_size:
      return "let the force return as many rows and columns as the state (its velocities) has, its Jacobian one of "
             "each per unknown";
    case Outcome::inconsistent_start:
      return "solve for the algebraic components first: make_consistent(stepper, state, t)";
    case Outcome::exception_elsewhere:
      return "see what the rank says that threw it";
  }
  return "";
}

/// Whether a smaller step may succeed where one failed so, the state itself being finite.
[[nodiscard]] constexpr bool may_be_cured(Outcome outcome) {
  switch (outcome) {
    case Outcome::non_finite_state:
    case Outcome::non_finite_force:
    case Outcome::non_finite_jacobian:
    case Outcome::singular_matrix:
    case Outcome::not_positive_definite:
    case Outcome::linear_solver_failed:
    case Outcome::newton_diverged:
    case Outcome::newton_stalled:
    case Outcome::iteration_diverged:
    case Outcome::iteration_stalled:
      return true;
    default:
      return false;
  }
}

}}  // namespace phistep::PHISTEP_ABI
