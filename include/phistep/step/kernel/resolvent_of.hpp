/// @file
/// What solves a scheme's implicit equations, by the scheme's needs and the user's solver.
#pragma once

#include <type_traits>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/solve/linear_stages.hpp"
#include "phistep/step/solve/resolvent.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Of an explicit scheme: nothing.
struct NoResolvent {
  explicit NoResolvent(const auto&...) {}
  static void forget() {}
  static void reset() {}
  static void resize(const auto&, const auto&) {}
};

template <class Solver>
struct LinearSolverOf {
  using type = void;
};
template <class Solver>
  requires requires { typename Solver::LinearSolver; }
struct LinearSolverOf<Solver> {
  using type = typename Solver::LinearSolver;
};

/// What linear stages are solved with. Shifted ones come with the schemes that have them (schemes/radau/shifted_stages.hpp).
template <State S, class Rhs, class LinearSolver, bool shifted>
struct StagesFor;
template <State S, class Rhs, class LinearSolver>
struct StagesFor<S, Rhs, LinearSolver, false> {
  using type = LinearStages<S, Rhs, LinearSolver>;
};

template <State S, class Rhs, class Solver, KernelNeeds needs>
[[nodiscard]] constexpr auto resolvent_type() {
  using LinearSolver = typename LinearSolverOf<Solver>::type;
  static_assert(
      !needs.stages || requires { typename Solver::LinearSolver; },
      "phistep: this scheme solves linear equations and iterates nothing: give it newton<LinearSolver>() or "
      "newton<MatrixFree<Eigen::BiCGSTAB>>(), not fixed_point()");
  if constexpr (needs.stages) return StagesFor<S, Rhs, LinearSolver, needs.shifted>{};
  else if constexpr (needs.solver) return ResolventFor<S, Rhs, Solver, needs.position>{};
  else return std::type_identity<NoResolvent>{};
}
template <State S, class Rhs, class Solver, KernelNeeds needs>
using ResolventOf = typename decltype(resolvent_type<S, Rhs, Solver, needs>())::type;

}}  // namespace phistep::PHISTEP_ABI
