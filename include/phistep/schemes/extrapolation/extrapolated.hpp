/// @file
/// Extrapolated schemes of variable order and step, as rows over the kernel:
///
///     PhiStepper stepper{y, force, extrapolated(forward_euler)};       Gragg's explicit midpoint rule, column k of order 2k
///     PhiStepper stepper{y, force, extrapolated(backward_euler)};      deprecated: linearly implicit Euler, order k
///     PhiStepper stepper{y, force, extrapolated(velocity_verlet)};     deprecated: motion whose force ignores v, order 2k
///
/// The first has no printed coefficients, and so serves any scalar to its last digits (extrapolation.hpp says what replaces
/// the others).
///
/// Under a tolerance each step chooses its columns and its length; without one it takes the columns given. The solution
/// inside its steps is not known to their accuracy: `sampled` and `step.at(t)` do not compile, `at_times` serves.
#pragma once

#include "phistep/core/phi.hpp"
#include "phistep/core/version.hpp"
#include "phistep/schemes/extrapolation/extrapolated_explicit.hpp"
#include "phistep/schemes/extrapolation/extrapolated_implicit.hpp"
#include "phistep/schemes/extrapolation/extrapolated_row.hpp"
#include "phistep/schemes/extrapolation/extrapolation.hpp"
#include "phistep/schemes/scheme_on.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State S>
class SchemeOn<Extrapolated<SinglePhi<FixedPhi<1>>>, S> : public ExtrapolatedRow<S, ImplicitEulerBase<S>> {
 public:
  using ExtrapolatedRow<S, ImplicitEulerBase<S>>::ExtrapolatedRow;
};

template <State S>
class SchemeOn<Extrapolated<SinglePhi<FixedPhi<0>>>, S> : public ExtrapolatedRow<S, GraggBase<S>> {
 public:
  using ExtrapolatedRow<S, GraggBase<S>>::ExtrapolatedRow;
};

template <State S>
class SchemeOn<Extrapolated<VelocityVerlet>, S> : public ExtrapolatedRow<S, VerletBase<S>> {
 public:
  using ExtrapolatedRow<S, VerletBase<S>>::ExtrapolatedRow;
};

}}  // namespace phistep::PHISTEP_ABI
