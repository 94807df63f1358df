/// @file
/// What the types and sizes of a problem say of it, for suitable_scheme.hpp.
#pragma once

#include <limits>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/run/choice/suitable_scheme.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/mass/mass.hpp"
#include "phistep/step/matrix/static_sparse_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What the types say of a problem.
/// @param y     gives the number of unknowns
/// @param rtol  that a run will be asked for
template <State S, class F, class MassSpec>
[[nodiscard]] AdvisedProblem scene_of(const PlainState<S>& y, const MassSpec& mass, double rtol) {
  using Masses = decltype(bind_masses<S>(mass, y));
  using Rhs = RightHandSide<S, F, Masses>;
  using Traits = typename Rhs::Traits;
  AdvisedProblem scene;
  scene.unknowns = unknowns<S>(y);
  scene.is_motion = Rhs::drifts;
  scene.uses_velocity = Rhs::drifts && Rhs::couples_unknowns;
  scene.has_history = Rhs::has_history;
  scene.has_jacobian = Traits::has_jacobian;
  scene.has_pattern = Traits::has_pattern;
  scene.is_affine = Traits::is_affine;
  scene.is_driven = Traits::uses_time;
  if constexpr (requires { Unwrapped<F>::jacobian_pattern; })
    scene.has_sparse_lu = has_sparse_pattern<Unwrapped<F>, static_unknowns<S>>;
  scene.structure = Traits::has_jacobian || Traits::has_pattern ? Traits::structure : Structure::dense;
  scene.rtol = rtol;
  scene.is_dynamic = static_unknowns<S> == Eigen::Dynamic;
  scene.digits = std::numeric_limits<ScalarOf<S>>::digits10;
  return scene;
}

}}  // namespace phistep::PHISTEP_ABI
