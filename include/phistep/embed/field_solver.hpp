/// @file
/// What solves the linear equations of a field: a class of the user's, or of an adapter. J never leaves it, nor does
/// W = M − γ_f C − γ_f γ_d K, with C = ∂Ψ/∂v and K = ∂Ψ/∂r (of a first-order field W = M − γ_f J). All its functions are
/// collective.
#pragma once

#include <concepts>
#include <cstdint>
#include <tuple>
#include <utility>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/equation/gamma.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @tparam S  a field, or a motion of two
template <class Solver, class S>
concept FieldSolver = FieldState<S> && std::copyable<Solver> && Solver::is_field_solver &&
    requires(Solver& one, const Solver& done, ScalarOf<S> t, const Gamma<ScalarOf<S>>& gamma,
             typename UnknownsOf<S>::type& x, const typename UnknownsOf<S>::type& y) {
  requires requires {
    { one.linearise(t, y) } -> std::same_as<Outcome>;
  } ||  // J at (t, y)
      (Blocks<S>::drifts && requires {
        { one.linearise(t, y, y) } -> std::same_as<Outcome>;
      });                                             // K and C at (t, r, v)
  { one.factorize(gamma) } -> std::same_as<Outcome>;  // W, and what its solves need
  {
    one.solve(x, double{})
    } -> std::same_as<Outcome>;  // x ← W⁻¹ x to that relative residual, 0: its own choice; x stays where it fails
  { done.iterations() } -> std::convertible_to<std::int64_t>;  // of the last solve
  { done.name() } -> std::convertible_to<const char*>;
};

}}  // namespace phistep::PHISTEP_ABI
