/// @file
/// Runs that choose their scheme, and change it where stiffness comes or goes:
///
///     auto report = phistep::integrate(y, robertson, {0.0, 1e11}, phistep::tolerance{.rtol = 1e-6, .atol = 1e-14});
///     std::cout << report;      // how it went, which schemes it took, when and why
///
/// and the stepper of such a run, for checkpoints and steps one by one:
///
///     AutomaticStepper stepper{y, robertson, 1e-6};
///     Run run{stepper, y, {0.0, 1e11}, tolerance{.rtol = 1e-6, .atol = 1e-14}};
///
/// They begin with an explicit scheme, unless the start is stiff already or M is singular; stiffness_watch.hpp says when they
/// change, suitable_scheme.hpp to what. One scheme exists at a time: where nothing is stiff there is no Jacobian and no matrix.
/// The changes cost an estimate of the rate ρ, three force calls each 25 steps or so, and no step is thrown away.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/run/choice/scheme_set.hpp"
#include "phistep/run/choice/scheme_uses.hpp"
#include "phistep/run/choice/spectral_radius.hpp"
#include "phistep/run/choice/stiffness_watch.hpp"
#include "phistep/run/choice/suitable_scheme.hpp"
#include "phistep/run/control/run_clock.hpp"
#include "phistep/run/errors/step_filter.hpp"
#include "phistep/run/errors/tolerance.hpp"
#include "phistep/run/run.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/mass/mass.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Steps a state S under a force F by the scheme that suits, as long as it does.
template <State S, class F, class MassSpec = UnitMasses>
class AutomaticStepper : public SchemesFor<S, F, MassSpec>::Stepper {
  using Schemes = SchemesFor<S, F, MassSpec>;
  using Base = typename Schemes::Stepper;
  static_assert(
      !Schemes::Rhs::has_history,
      "phistep: no scheme is chosen for a force with a history (contacts, friction): it wants steps that resolve an "
      "impact, of equal length; take PhiStepper{..., velocity_verlet} with fixed(dt), phistep::preflight says how "
      "long");
  static_assert(std::is_copy_constructible_v<S>,
                "phistep: no scheme is chosen for a state in place: make a PhiStepper");

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  /// @param state  gives the sizes; views are kept, other states are not
  /// @param force  copied for each scheme that is taken; wrap it in std::ref to keep it outside
  /// @param rtol   that its runs will be asked for: which scheme is best depends on it
  /// @param mass   mass(m) or capacity(C); M = 1 if left out
  AutomaticStepper(const S& state, F force, double rtol, MassSpec mass = {})
      : AutomaticStepper{state, std::move(force), Schemes::scene(plain_of(state), rtol), std::move(mass)} {}
  /// The same for a problem that has been described already.
  AutomaticStepper(const S& state, F force, const AdvisedProblem& problem, MassSpec mass = {})
      : AutomaticStepper{problem, bool{algebraic_component(bind_masses<S>(mass, plain_of(state)))}, state,
                         std::move(force), std::move(mass)} {}

  /// Where a run begins, its first step proposed: takes an implicit scheme where that step says stiff. Of the first run only.
  /// @param pace  of the run. @return whether it did: the first step is then to be proposed anew
  [[nodiscard]] bool begin_run(const S& state, const Plain& y, const RunClock<Scalar>& clock, auto& pace) {
    if (is_bound_ || look_.has_looked()) return false;
    const RateSeen& seen = look(y, clock, pace);
    return watch_.starts_stiff(seen, problem_.unknowns <= few_unknowns) &&
           change(state, y, clock, pace, seen, SchemeCause::stiff_start);
  }
  /// Before each step of a run: takes another scheme where that would serve better.
  /// @return [time] the longest step that a new scheme should begin with, nothing where it stays
  [[nodiscard]] std::optional<double> choose(const S& state, const Plain& y, const RunClock<Scalar>& clock,
                                             auto& pace) {
    if (is_bound_ || done_ == 0) return {};
    watch_.accepted(pace.propose());
    steps_ += std::exchange(done_, 0);
    if (!watch_.is_due()) return {};
    const RateSeen& seen = look(y, clock, pace);
    if (wants_pattern(seen)) note(clock.t(), seen, SchemeCause::stays_explicit);
    const SchemeCause cause = watch_.is_implicit() ? SchemeCause::eased : SchemeCause::stiff;
    if (!watch_.judge(seen) || !change(state, y, clock, pace, seen, cause)) return {};
    return watch_.is_implicit() ? seen.dt : watch_.stable_step(seen);
  }
  [[nodiscard]] SuitableScheme scheme() const { return scheme_of(this->active()); }
  [[nodiscard]] const AdvisedProblem& problem() const { return problem_; }
  /// What it took, when and why.
  [[nodiscard]] const SchemeUses& uses() const& { return uses_; }
  [[nodiscard]] SchemeUses uses() && { return std::move(uses_); }
  [[nodiscard]] const RateSeen& seen() const { return look_.seen(); }
  /// Whether it is, or would be if it could, at an implicit scheme.
  [[nodiscard]] bool is_stiff() const { return watch_.is_implicit() || is_bound_; }

  StepReport attempt(S& state, Scalar t, Scalar dt, Origin origin, Trace<Plain>& trace, const Judge<Plain>& accept) {
    StepReport report = Base::attempt(state, t, dt, origin, trace, accept);
    if constexpr (Schemes::is_field)
      if (is_by_krylov(scheme()) && is_of_solver(report.outcome())) {
        is_direct_ = true;  // from now on
        problem_.field = {};
        replace_by(Schemes::suitable_implicit(problem_), state);
        note(t, seen(), SchemeCause::unsolved);
        report = Base::attempt(state, t, dt, origin, trace, accept);
      }
    if (report) ++done_;
    else if (report.outcome() == Outcome::error_too_large) watch_.rejected();
    return report;
  }
  [[nodiscard]] friend ErrorLaw error_law(const AutomaticStepper& stepper) { return stepper.law(); }

  /// As PhiStepper's, with which scheme is at work, and what led to it.
  template <class Ar>
  void archive(Ar& ar) {
    int active = this->active();
    ar.aside("active", active);
    ar.check(0 <= active && active < static_cast<int>(Schemes::all.size()));
    ar("watch", watch_, "look", look_, "uses", uses_, "steps", steps_, "done", done_, "is_bound", is_bound_,
       "is_direct", is_direct_);
    ar.check(can_be_count(steps_) && can_be_count(done_));
    if constexpr (Ar::reading) {
      const auto fresh =
          std::make_shared<Base>([&] { return Schemes::make(scheme_of(active), sample(), force_, mass_); });
      ar.aside("scheme", *fresh);
      ar.at_last([this, fresh] { static_cast<Base&>(*this) = std::move(*fresh); });
    } else {
      ar("scheme", static_cast<Base&>(*this));
    }
  }

 private:
  AutomaticStepper(const AdvisedProblem& problem, bool is_algebraic, const S& state, F&& force, MassSpec&& mass)
      : Base{[&] {
          return Schemes::make(is_algebraic ? Schemes::suitable_implicit(problem) : suitable_explicit(problem), state,
                               force, mass);
        }},
        force_{std::move(force)},
        mass_{std::move(mass)},
        problem_{problem},
        watch_{Schemes::rivals(problem)},
        look_{plain_of(state)},
        is_bound_{is_algebraic},
        view_{state} {
    uses_.add({.scheme = scheme(), .cause = is_algebraic ? SchemeCause::algebraic : SchemeCause::start});
  }
  /// Whether a failure of Krylov iterations says that they do not suit W; a Jacobian is checked by solves, too.
  [[nodiscard]] static bool is_of_solver(Outcome outcome) {
    using enum Outcome;
    return outcome == linear_solver_failed || outcome == not_positive_definite || outcome == not_symmetric ||
           outcome == wrong_jacobian || outcome == not_affine;
  }
  [[nodiscard]] static SuitableScheme scheme_of(int number) { return Schemes::all[static_cast<std::size_t>(number)]; }
  /// The state itself; of a view, a copy.
  [[nodiscard]] static decltype(auto) plain_of(const S& state) {
    if constexpr (is_view) {
      Plain copy;
      copy_blocks<S>(copy, state);
      return copy;
    } else {
      return (state);
    }
  }

  const RateSeen& look(const Plain& y, const RunClock<Scalar>& clock, auto& pace) {
    const auto slope = [this](Scalar t, const Plain& x, Plain& out) { return this->slope(t, x, out); };
    return look_(slope, y, clock, pace, !watch_.is_implicit());
  }
  /// Explicit steps are at their limit, and with a pattern an implicit scheme would cost far less. Said once.
  [[nodiscard]] bool wants_pattern(const RateSeen& seen) const {
    if (problem_.has_jacobian || problem_.has_pattern || problem_.unknowns <= few_unknowns ||
        !Schemes::can_be_implicit(problem_))
      return false;
    for (const SchemeUse& use : uses_.list())
      if (use.cause == SchemeCause::stays_explicit) return false;
    return watch_.is_at_limit(seen) && watch_.pays(seen, 2 * Schemes::cost_with_pattern(problem_));
  }
  /// Takes the scheme of the other kind, if it can and that pays.
  [[nodiscard]] bool change(const S& state, const Plain& y, const RunClock<Scalar>& clock, auto& pace,
                            const RateSeen& seen, SchemeCause cause) {
    const bool to_explicit = cause == SchemeCause::eased;
    if (!to_explicit && !Schemes::can_be_implicit(problem_)) {
      is_bound_ = true;
      note(clock.t(), seen, SchemeCause::stays_explicit);
      return false;
    }
    problem_.oscillates = oscillates(seen);
    if (to_explicit) replace_by(suitable_explicit(problem_), state);
    else if (!take_implicit(state, y, clock, pace, seen)) return false;
    if (cause == SchemeCause::stiff_start) watch_.begin_implicit();
    else watch_.change();
    note(clock.t(), seen, cause);
    return true;
  }
  /// Takes the implicit scheme that suits, if it pays.
  [[nodiscard]] bool take_implicit(const S& state, const Plain& y, const RunClock<Scalar>& clock, auto& pace,
                                   const RateSeen& seen) {
    using enum SuitableScheme;
    if constexpr (Schemes::is_field)
      if (!is_direct_)
        return suitable_by_krylov(problem_.rtol) == rodas_4_krylov
                   ? take_counted<rodas_4_krylov>(state, y, clock, pace, seen)
                   : take_counted<rodas_5p_krylov>(state, y, clock, pace, seen);
    if (!watch_.pays(seen)) return false;
    replace_by(Schemes::suitable_implicit(problem_), state);
    return true;
  }
  /// The same of a large sparse matrix, which is counted in the stepper that will solve with it by Krylov iterations, unless the count
  /// speaks for a factorization: then its first step finds the Jacobian there.
  template <SuitableScheme by_krylov>
  [[nodiscard]] bool take_counted(const S& state, const Plain& y, const RunClock<Scalar>& clock, auto& pace,
                                  const RateSeen& seen) {
    typename Base::Steppers fresh = Schemes::make(by_krylov, state, force_, mass_);
    auto& stepper = *std::get_if<StepperNamed<by_krylov, S, F, MassSpec>>(&fresh);
    const SolveTolerance<Plain> weights{&pace.trace().weight, 1, pace.weigh(y, pace.trace().weight)};
    problem_.turns = seen.rate * seen.left;
    problem_.field = FieldMatrix<Scalar>::template count<S>(
        stepper, clock.t(), clock.sign() * static_cast<Scalar>(seen.dt), y, weights, problem_);
    watch_.set_implicit_cost(Schemes::rivals(problem_, false).implicit_cost);
    const bool pays = watch_.pays(seen);
    const SuitableScheme scheme = Schemes::suitable_implicit(problem_);
    if (pays && scheme == by_krylov) return this->replace(std::move(fresh)), true;
    this->add(stepper.statistics());
    if (pays) replace_by(scheme, state);
    return pays;
  }
  void replace_by(SuitableScheme scheme, const S& state) { this->replace(Schemes::make(scheme, state, force_, mass_)); }
  void note(Scalar t, const RateSeen& seen, SchemeCause cause) {
    const double entries = watch_.is_implicit() ? problem_.field.entries : -1;
    uses_.add({scheme(), cause, static_cast<double>(t), steps_, seen.rate, seen.dt, entries});
  }
  [[nodiscard]] const S& sample() const {
    if constexpr (is_view) return view_;
    else return look_.sample();
  }

  static constexpr bool is_view = !std::is_same_v<S, Plain>;

  F force_;
  [[no_unique_address]] MassSpec mass_;
  AdvisedProblem problem_;
  StiffnessWatch watch_;
  RateLook<Plain> look_;
  bool is_bound_;           // to the scheme at work, although or because it is stiff
  bool is_direct_ = false;  // Krylov iterations have failed: no more of them
  SchemeUses uses_{};
  std::int64_t steps_ = 0, done_ = 0;  // steps seen, steps since
  [[no_unique_address]] Only<is_view, S> view_;
};

/// Advances y from span.t0 to exactly span.t1, forward or backward, by schemes that it chooses and changes by itself.
/// @param force      f(y), f(y, t), f(r), f(r, v), f(r, v, t), a term or a sum of terms, as for PhiStepper
/// @param mass       mass(m) or capacity(C)
/// @param wanted     the error wanted of the result
/// @param observers  as with a stepper
/// @return outcome, time reached, counts, schemes; on failure y is that of the last good step
template <State S, class F, class MassSpec, class... Observers>
  requires(is_mass_spec<MassSpec>)
AutomaticReport integrate(S& y, F&& force, const MassSpec& mass, TimeSpan<std::type_identity_t<ScalarOf<S>>> span,
                          const tolerance& wanted, Observers&&... observers) {
  auto outside = std::ref(unwrap(force));  // not copied
  AutomaticStepper<S, decltype(outside), MassSpec> stepper{y, outside, wanted.rtol, mass};
  Run<decltype(stepper), S, tolerance, Observers...> run{stepper, y, span, wanted,
                                                         std::forward<Observers>(observers)...};
  return {run.finish(), std::move(stepper).uses()};
}
template <State S, class F, class... Observers>
AutomaticReport integrate(S& y, F&& force, TimeSpan<std::type_identity_t<ScalarOf<S>>> span, const tolerance& wanted,
                          Observers&&... observers) {
  return integrate(y, force, UnitMasses{}, span, wanted, std::forward<Observers>(observers)...);
}

/// No run: says why.
template <State S, class F, class Control, class... Observers>
  requires(!is_mass_spec<std::remove_cvref_t<Control>> && !std::is_convertible_v<Control, const tolerance&>)
AutomaticReport integrate(S&, F&&, TimeSpan<std::type_identity_t<ScalarOf<S>>>, const Control&, Observers&&...) {
  static_assert(!sizeof(Control),
                "phistep: integrate without a stepper chooses dt by its error: tolerance{.rtol = 1e-6}; other controls "
                "take a PhiStepper");
  return {};
}

}}  // namespace phistep::PHISTEP_ABI
