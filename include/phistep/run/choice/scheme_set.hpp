/// @file
/// What a problem's types say of it, and which schemes are compiled for them, as a stepper that can choose among them as it goes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

#include "phistep/base/archive/archive_kinds.hpp"
#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/facts/structure.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/run/choice/stiffness_watch.hpp"
#include "phistep/run/choice/suitable_scheme.hpp"
#include "phistep/run/errors/step_filter.hpp"
#include "phistep/run/stepper/any_stepper.hpp"
#include "phistep/run/stepper/phi_stepper.hpp"
#include "phistep/schemes/nystrom/nystrom.hpp"
#include "phistep/schemes/radau/radau.hpp"
#include "phistep/schemes/rosenbrock.hpp"
#include "phistep/schemes/runge_kutta/runge_kutta.hpp"
#include "phistep/schemes/tr_bdf2.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/jacobian/differences.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/mass/mass.hpp"
#include "phistep/step/matrix/static_sparse_system.hpp"
#include "phistep/step/transaction/trace.hpp"

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

/// Defined in <phistep/sparse.hpp>: the Krylov solver for large sparse fields, and the counts by which it is chosen.
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

/// A std::variant of steppers of one state, as a stepper: one exists at a time, and every call goes to that one.
template <class S, class... Stepper>
class ActiveStepper {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using StateType = S;
  using Steppers = std::variant<Stepper...>;
  using Checkpoint = std::variant<typename Stepper::Checkpoint...>;
  using ArchivedByParts = void;
  static constexpr const char* part_name = "stepper";

  /// @param make  make() → Steppers that hold the first one to be at work: in place, not moved
  template <class Make>
    requires std::is_invocable_r_v<Steppers, const Make&>
  explicit ActiveStepper(const Make& make) : steppers_(make()) {}

  [[nodiscard]] int active() const { return static_cast<int>(steppers_.index()); }
  /// Another one takes over; but for the counts, and the sizes of a run before, what the last one knew is lost.
  void replace(Steppers next) {
    retired_ = statistics();
    changes_ = changes();
    visit_numbered(next, [this](auto number, auto& stepper) {
      if constexpr (!FieldState<S>) StepperInternals::kept_sizes(stepper) = std::move(kept_sizes(*this));
      steppers_.template emplace<number>(std::move(stepper));
    });
  }

  /// A step at a given Δt. [time]
  StepReport step(S& state, Scalar t, Scalar dt, Origin origin = Origin::unknown) {
    return visit(*this, [&](auto& at_work) { return at_work.step(state, t, dt, origin); });
  }
  // What a run controlled by its error asks beside steps: what the stepper at work can tell.
  static constexpr StepperFacts facts = [] {
    StepperFacts all = facts_of<void>;  // what is safe
    all.traces = all.interpolates = true;
    return all;
  }();
  [[nodiscard]] bool estimates(const Trace<Plain>& trace) const {
    return visit(*this, [&](auto& at_work) { return at_work.estimates(trace); });
  }
  StepReport attempt(S& state, Scalar t, Scalar dt, Origin origin, Trace<Plain>& trace, const Judge<Plain>& accept) {
    return visit(*this, [&](auto& at_work) { return at_work.attempt(state, t, dt, origin, trace, accept); });
  }
  [[nodiscard]] ErrorLaw law() const {
    return visit(*this, [](auto& at_work) { return error_law(at_work); });
  }
  [[nodiscard]] int order() const {
    return visit(*this, [](auto& at_work) { return at_work.order(); });
  }
  [[nodiscard]] bool slope(Scalar t, const Plain& y, Plain& out) {
    return visit(*this, [&](auto& at_work) { return at_work.slope(t, y, out); });
  }
  [[nodiscard]] const SolveRecord& last_solve() const {
    return visit(*this, [](auto& at_work) -> const SolveRecord& { return at_work.last_solve(); });
  }
  [[nodiscard]] Statistics statistics() const {
    return retired_ + visit(*this, [](auto& at_work) -> Statistics { return at_work.statistics(); });
  }
  [[nodiscard]] std::int64_t changes() const {
    return changes_ + visit(*this, [](auto& at_work) { return at_work.changes(); });
  }
  /// Counts what one that was never at work has cost.
  void add(const Statistics& cost) { retired_ = retired_ + cost; }
  [[nodiscard]] Checkpoint checkpoint() const {
    return visit_numbered(steppers_, [](auto number, auto& at_work) {
      return Checkpoint{std::in_place_index<number>, at_work.checkpoint()};
    });
  }
  /// To a point that another stepper may have known: then this one has nothing from there.
  void restore(Checkpoint checkpoint) {
    visit_numbered(steppers_, [&](auto number, auto& at_work) {
      if (auto* const past = std::get_if<number>(&checkpoint)) at_work.restore(std::move(*past));
      else at_work.reset();
    });
  }
  void forget_unsaved() {
    visit(*this, []<class AtWork>(AtWork& at_work) {
      if constexpr (HasUnsaved<AtWork>) at_work.forget_unsaved();
    });
  }
  void archive(auto& ar) {
    ar("retired", retired_, "changes", changes_);
    visit(*this, [&ar](auto& at_work) { at_work.archive(ar); });
  }

 private:
  friend StepperInternals;

  /// f(std::integral_constant<std::size_t, number>, the stepper of that number, which is at work)
  template <std::size_t i = 0>
  [[gnu::always_inline]] static inline decltype(auto) visit_numbered(auto& steppers, auto&& f) {
    if constexpr (i + 1 < sizeof...(Stepper))
      if (steppers.index() != i) return visit_numbered<i + 1>(steppers, f);
    return f(std::integral_constant<std::size_t, i>{}, *std::get_if<i>(&steppers));
  }
  [[gnu::always_inline]] static inline decltype(auto) visit(auto& self, auto&& f) {
    return visit_numbered(self.steppers_, [&f](auto, auto& at_work) -> decltype(auto) { return f(at_work); });
  }

  Steppers steppers_;
  Statistics retired_{};      // of those before
  std::int64_t changes_ = 0;  // of the forces of these
};

/// The schemes for a state S under a force F with a mass.
template <State S, class F, class MassSpec>
struct SchemesFor {
  using Masses = decltype(bind_masses<S>(std::declval<const MassSpec&>(), std::declval<const PlainState<S>&>()));
  using Rhs = RightHandSide<S, typename SteppedForce<S, F>::type, Masses>;
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

  /// What the types say of a problem.
  /// @param y     gives the number of unknowns
  /// @param rtol  that a run will be asked for
  [[nodiscard]] static AdvisedProblem scene(const PlainState<S>& y, double rtol) {
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
    if ((scene.has_jacobian || scene.has_pattern) && (is_network || Traits::structure != Structure::network))
      scene.structure = Traits::structure;
    scene.rtol = rtol;
    scene.is_dynamic = static_unknowns<S> == Eigen::Dynamic;
    scene.digits = std::numeric_limits<ScalarOf<S>>::digits10;
    return scene;
  }
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
