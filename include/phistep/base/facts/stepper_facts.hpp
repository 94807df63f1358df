/// @file
/// What the type of a stepper says of it: `Stepper::facts`, without defaults, so that a stepper around a stepper says each
/// for itself, or doesn't compile. One of a user's own need not have any.
#pragma once

#include <array>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

struct StepperFacts {
  Fact<bool> traces;          ///< it has `attempt`, which can tell how large a step's error is
  Fact<bool> interpolates;    ///< it knows the solution inside the step just accepted better than its ends tell
  Fact<bool> is_sure_inside;  ///< … to what its estimate of a step's error allows, with no need of a check
  Fact<bool> solves_nothing;  ///< stability keeps Δt within what slopes at both ends can tell
  Fact<bool> reads_weights;   ///< its steps read trace.weight: solves to the tolerance, estimates of its own
  Fact<bool> refactorizes;    ///< each step makes its matrix anew, so that keeping Δt spares nothing
  Fact<bool> is_affine;       ///< one factorization serves all steps of one Δt
  Fact<std::array<double, 2>> doubtful_at;  ///< where in a step, 0 < x < 1, its interpolant is worst
};

/// Seven tenths of the largest error and more: of Hermite's interpolant, which goes as x²(1−x)², and as x(1−x)(1−2x) where
/// slopes are wrong; of collocation at Radau's 3, 5 or 7 nodes, which goes as ∫Π(x−c_i), and as xΠ(x−c_i) where it is stiff.
inline constexpr std::array<double, 2> usually_doubtful{0.35, 0.68};

/// The facts of a stepper; of one that says nothing, what is safe.
template <class Stepper>
inline constexpr StepperFacts facts_of{.traces = false,
                                       .interpolates = false,
                                       .is_sure_inside = false,
                                       .solves_nothing = false,
                                       .reads_weights = true,
                                       .refactorizes = false,
                                       .is_affine = false,
                                       .doubtful_at = usually_doubtful};
template <class Stepper>
  requires requires { Stepper::facts; }
inline constexpr StepperFacts facts_of<Stepper> = Stepper::facts;

}}  // namespace phistep::PHISTEP_ABI
