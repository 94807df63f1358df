/// @file
/// What a problem's types say of it, and which schemes are compiled for them, so that a stepper can choose among them as it goes.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/facts/structure.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/run/choice/active_stepper.hpp"
#include "phistep/run/choice/stiffness_watch.hpp"
#include "phistep/run/choice/suitable_scheme.hpp"
#include "phistep/run/stepper/phi_stepper.hpp"
#include "phistep/schemes/nystrom/nystrom.hpp"
#include "phistep/schemes/radau/radau.hpp"
#include "phistep/schemes/rosenbrock.hpp"
#include "phistep/schemes/runge_kutta/runge_kutta.hpp"
#include "phistep/schemes/tr_bdf2.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/jacobian/differences.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/mass/mass.hpp"
#include "phistep/step/matrix/static_sparse_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The scheme of a name, as its type.
template <SuitableScheme scheme>
[[nodiscard]] constexpr auto scheme_named() {
  if constexpr (scheme == SuitableScheme::dormand_prince_8) return dop853;
  else if constexpr (scheme == SuitableScheme::nystrom_8) return rkn86;
  else if constexpr (scheme == SuitableScheme::nystrom_12) return rkn1210;
  else if constexpr (scheme == SuitableScheme::rodas_4 || scheme == SuitableScheme::rodas_4_krylov) return rodas4p2;
  else if constexpr (scheme == SuitableScheme::radau_iia) return radau;
  else if constexpr (scheme == SuitableScheme::tr_bdf_2) return tr_bdf2;
  else return rodas5p;
}

/// Of <phistep/sparse.hpp>: the solver of large fields, and what has to be counted to choose it.
template <class Scalar>
struct FieldMatrix;

/// How a scheme's implicit equations are solved, as the type.
template <SuitableScheme scheme, class Scalar>
[[nodiscard]] constexpr auto solver_named() {
  if constexpr (is_by_krylov(scheme)) return typename FieldMatrix<Scalar>::Solver{};
  else return newton();
}
template <SuitableScheme scheme, class S, class F, class MassSpec>
using StepperNamed = PhiStepper<S, F, std::remove_const_t<decltype(scheme_named<scheme>())>, MassSpec,
                                decltype(solver_named<scheme, ScalarOf<S>>())>;

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
  const bool is_known = (Traits::has_jacobian || Traits::has_pattern) &&
                        !(Traits::structure == Structure::network && Rhs::has_matrix_mass);
  scene.structure = is_known ? Traits::structure : Structure::dense;
  scene.rtol = rtol;
  scene.is_dynamic = static_unknowns<S> == Eigen::Dynamic;
  scene.digits = std::numeric_limits<ScalarOf<S>>::digits10;
  return scene;
}

/// The schemes for a state S under a force F with a mass.
template <State S, class F, class MassSpec>
struct SchemesFor {
  using Masses = decltype(bind_masses<S>(std::declval<const MassSpec&>(), std::declval<const PlainState<S>&>()));
  using Rhs = RightHandSide<S, F, Masses>;
  static constexpr bool is_network = Rhs::Traits::structure == Structure::network && !Rhs::has_matrix_mass,
                        is_nystrom = Rhs::drifts && !Rhs::couples_unknowns,
                        is_field = (Rhs::Traits::has_jacobian || Rhs::Traits::has_pattern) &&
                                   combine(Rhs::Traits::structure, Rhs::mass_structure) == Structure::sparse &&
                                   static_unknowns<S> == Eigen::Dynamic;
  /// Explicit ones first. Pairs of particles are solved by conjugate gradients, which serve schemes that resolve; large sparse
  /// matrices by direct solvers or by Krylov iterations.
  static constexpr auto all = [] {
    using enum SuitableScheme;
    const auto with = [](auto... implicit) {
      if constexpr (is_nystrom) return std::array{nystrom_8, nystrom_12, implicit...};
      else return std::array{dormand_prince_8, implicit...};
    };
    if constexpr (is_network) return with(tr_bdf_2);
    else if constexpr (is_field) return with(rodas_4, rodas_5p, radau_iia, rodas_4_krylov, rodas_5p_krylov);
    else return with(rodas_4, rodas_5p, radau_iia);
  }();
  template <std::size_t... i>
  static auto one_of(std::index_sequence<i...>) -> ActiveStepper<S, StepperNamed<all[i], S, F, MassSpec>...>;
  using Stepper = decltype(one_of(std::make_index_sequence<all.size()>{}));

  [[nodiscard]] static SuitableScheme suitable_implicit(AdvisedProblem problem) {
    problem.has_jacobian = problem.has_jacobian || can_be_implicit(problem);
    return phistep::suitable_implicit(problem);
  }
  /// Whether there can be a matrix.
  [[nodiscard]] static bool can_be_implicit(const AdvisedProblem& problem) {
    return problem.has_jacobian || problem.has_pattern || problem.unknowns <= dense_difference_limit;
  }
  /// What StiffnessWatch compares.
  /// @param may_be_krylov  the kind of a large sparse matrix isn't known yet: it is priced as one for Krylov iterations
  [[nodiscard]] static RivalSteps rivals(AdvisedProblem problem, bool may_be_krylov = is_field) {
    if (!can_be_implicit(problem)) {  // what it would cost with a pattern: then the report names one
      problem.has_pattern = true;
      problem.structure = Structure::sparse;
    }
    const SuitableScheme one = phistep::suitable_explicit(problem),
                         other = may_be_krylov ? suitable_by_krylov(problem.rtol) : suitable_implicit(problem);
    return {row_of(one).bound, step_cost(one, problem), step_cost(other, problem)};
  }
  /// What an implicit step would cost if the Jacobian had a band.
  [[nodiscard]] static double cost_with_pattern(AdvisedProblem problem) {
    problem.has_pattern = true;
    problem.structure = Structure::banded;
    return step_cost(suitable_implicit(problem), problem);
  }
  /// One of the schemes, as a stepper.
  template <std::size_t i = 0>
  [[nodiscard]] static typename Stepper::Steppers make(SuitableScheme scheme, const S& state, const F& force,
                                                       const MassSpec& mass) {
    constexpr SuitableScheme name = all[i];
    if constexpr (i + 1 < all.size())
      if (scheme != name) return make<i + 1>(scheme, state, force, mass);
    return typename Stepper::Steppers{std::in_place_index<i>, state, force,
                                      scheme_named<name>(),   mass,  solver_named<name, ScalarOf<S>>()};
  }
};

}}  // namespace phistep::PHISTEP_ABI
