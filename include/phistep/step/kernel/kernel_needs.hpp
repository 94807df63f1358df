/// @file
/// What schemes ask of the kernel.
#pragma once

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a scheme asks of the kernel for a given right-hand side.
struct KernelNeeds {
  bool solver = false;   ///< it resolves where there is something to solve
  bool position = true;  ///< … with γ_d ≠ 0, so that K matters
  bool carries = false;  ///< it may leave Ψ(t+Δt) to the next step
  bool stages = false;   ///< it solves linear equations instead
  bool shifted = false;  ///< … with several complex matrices
  int passes = 0;        ///< explicit: 1, a step is one kick_drift; 2, a kick follows it and ends the step; 0, neither
};

/// Whether Ψ(t+Δt) could be kept at all: a force with a history may have changed it by then, a look-up isn't worth it.
template <class Rhs>
inline constexpr bool can_carry = !Rhs::has_history && !Rhs::Traits::is_lookup;

template <class Solver>
inline constexpr bool is_linearly_implicit = false;
template <class LinearSolver>
inline constexpr bool is_linearly_implicit<LinearlyImplicit<LinearSolver>> = true;

}}  // namespace phistep::PHISTEP_ABI
