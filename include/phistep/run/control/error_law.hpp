/// @file
/// What a step-size controller has to know of a stepper: orders, and what a change of Δt costs.
#pragma once

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/errors/step_filter.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// How the error of a scheme's steps goes with their length, and what a new length costs.
struct ErrorLaw {
  int order = 1;                          ///< of the scheme
  int error_order = 2;                    ///< the power of Δt with which its estimate goes
  double dead_band = 1;                   ///< see StepSize; more than 1 where a kept Δt spares a factorization
  bool reads_weights = true;              ///< steps read trace.weight
  StepFilter filter = StepFilter::H211b;  ///< the one that suits, unless the user names another
  bool looks_for_jumps = false;           ///< its estimate falls as that power, or the force isn't smooth (Smoothness)
};

/// By how much Δt has to grow to be worth new factors: without a matrix, at once; Newton makes do with old ones within
/// limits; an affine step can't, and a factorization is then most of what it costs.
template <class Stepper>
[[nodiscard]] double dead_band(const Stepper& stepper) {
  if constexpr (facts_of<Stepper>.refactorizes) return 1;
  if constexpr (requires { stepper.keeps_factors(); })
    if (!stepper.keeps_factors()) return 1;
  if constexpr (facts_of<Stepper>.is_affine) return 2;
  else return 1.2;
}

template <class Stepper>
[[nodiscard]] ErrorLaw error_law(const Stepper& stepper) {
  ErrorLaw law{stepper.order(), stepper.order() + 1, dead_band(stepper), facts_of<Stepper>.reads_weights,
               StepFilter::H211b};
  if constexpr (requires { stepper.error_order(); }) law.error_order = stepper.error_order();
  if constexpr (facts_of<Stepper>.refactorizes) law.filter = StepFilter::predictive;
  else if (law.dead_band > 1) law.filter = StepFilter::PI42;
  else if (law.order >= 5) {
    law.filter = StepFilter::predictive;                     // where Δt changes by a fifth, errors do by a decade
    law.looks_for_jumps = !facts_of<Stepper>.reads_weights;  // those with estimates of their own do it themselves
  }
  return law;
}

}}  // namespace phistep::PHISTEP_ABI
