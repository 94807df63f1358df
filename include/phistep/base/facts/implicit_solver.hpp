/// @file
/// How the implicit equations are solved: the last argument of a stepper, what a controlled run asks of a solve, and what a scheme asks
/// of the kernel (KernelNeeds).
#pragma once

#include <utility>

#include "phistep/base/machine/memory.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// When to stop. rtol = 0 means: iterate to rounding.
struct NewtonOptions {
  double rtol = 0;           ///< relative tolerance of the step that this solve serves
  double atol = 0;           ///< absolute tolerance, in the state's units
  int max_iterations = 0;    ///< 0: 7 with a tolerance, 25 to rounding
  double linear_rtol = 0;    ///< relative residual at which an iterative linear solver stops; 0: its own choice
  bool line_search = false;  ///< damp corrections from the start, for forces with kinks; without it, on failure only
};

/// A way to solve the implicit equations, as the last argument of a stepper.
template <class T>
concept ImplicitSolver = requires {
  requires T::is_implicit_solver;
};

/// Whether a linear solver is a preconditioned Krylov method on a sparse matrix.
template <class Solver>
inline constexpr bool is_preconditioned_krylov = false;

/// A linear solver that is handed over, and not made by the library.
template <class Solver>
concept GivenSolver = is_preconditioned_krylov<Solver> || requires {
  requires Solver::is_field_solver;
};

/// Newton's iteration: `Solver` is a class with Eigen's sparse solver interface, void the library's own choice.
/// @tparam once  one correction is all
template <class Solver = void, bool once = false>
struct Newton {
  static constexpr bool is_implicit_solver = true;
  using LinearSolver = Solver;
  NewtonOptions options;
  [[no_unique_address]] Only<GivenSolver<Solver>, Solver> linear{};  ///< what it holds, a preconditioner say, is copied
};

/// Whether a linear solver wants products with W in place of a matrix.
template <class Solver>
inline constexpr bool is_matrix_free = false;

/// How the implicit equations are solved, e.g. `newton<Eigen::SimplicialLDLT<Matrix>>()`, `newton({.rtol = 1e-6})`.
template <class Solver = void>
[[nodiscard]] constexpr Newton<Solver> newton(NewtonOptions options = {}) {
  return {options};
}
/// The same with a solver that holds something, `newton(PreconditionedGmres<P>{mine})`.
template <GivenSolver Solver>
[[nodiscard]] constexpr Newton<Solver> newton(Solver linear, NewtonOptions options = {}) {
  return {options, std::move(linear)};
}

/// One Newton correction with a fresh Jacobian, accepted as it is: the linearly implicit step. Order as the scheme's for
/// smooth forces (φ = ½ stays of order 2); the residual that it leaves in the nonlinear equations is not checked.
template <class Solver = void>
using LinearlyImplicit = Newton<Solver, true>;

/// `linearly_implicit()`, `linearly_implicit<Eigen::SimplicialLDLT<Matrix>>()`
template <class Solver = void>
[[nodiscard]] constexpr LinearlyImplicit<Solver> linearly_implicit(NewtonOptions options = {}) {
  return {options};
}

/// The weights of a controlled run's norm, and the error that a solve may leave in it; target 0: the options above rule.
template <class Plain>
struct SolveTolerance {
  const Plain* weight = nullptr;  ///< 1/(atol + rtol |y|)
  double target = 0;
  double rtol = 0;
  const Plain* usual = nullptr;  ///< sizes for differences; null: those of the weights
  bool has_unsized = false;      ///< where the weight is 0, a correction is measured by the iterate
};

/// What a scheme asks of the kernel for a given right-hand side.
struct KernelNeeds {
  bool solver = false;   ///< it resolves where there is something to solve
  bool position = true;  ///< it resolves with γ_d ≠ 0, so that K matters
  bool carries = false;  ///< a step may leave Ψ(t+Δt) to the next step
  bool stages = false;   ///< it solves linear equations of stages, not resolves
  bool shifted = false;  ///< it solves with several (λ/h) M − J, λ complex
  /// What makes up the whole of an explicit step: 1, one kick_drift; 2, a kick after it. 0: a solve follows, or stages.
  int passes = 0;
};

/// Whether Ψ(t+Δt) could be kept at all: a force with a history may have changed it by then, and one that reads a table costs too little.
template <class Rhs>
inline constexpr bool can_carry = !Rhs::has_history && !Rhs::Traits::is_lookup;

template <class Solver>
inline constexpr bool is_linearly_implicit = false;
template <class LinearSolver>
inline constexpr bool is_linearly_implicit<Newton<LinearSolver, true>> = true;

}}  // namespace phistep::PHISTEP_ABI
