/// @file
/// A stepper that chooses its scheme, and changes it where stiffness comes or goes:
///
///     AutomaticStepper stepper{y, robertson, 1e-6};
///     Run run{stepper, y, {0.0, 1e11}, tolerance{.rtol = 1e-6, .atol = 1e-14}};
///
/// It begins with an explicit scheme, unless the start is stiff already or M is singular; stiffness_watch.hpp says when it
/// changes, choice.hpp to what. One scheme exists at a time: where nothing is stiff there is no Jacobian and no matrix.
/// The changes cost a look at the rate ρ, three force calls each 25 steps or so, and no step is thrown away.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "phistep/archive/archive.hpp"
#include "phistep/control/run_clock.hpp"
#include "phistep/control/spectral_radius.hpp"
#include "phistep/control/trace.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/stepper_facts.hpp"
#include "phistep/core/version.hpp"
#include "phistep/jacobian/differences.hpp"
#include "phistep/linear/mass.hpp"
#include "phistep/problem/transaction.hpp"
#include "phistep/schemes/advised_problem.hpp"
#include "phistep/schemes/step_cost.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/combination.hpp"
#include "phistep/state/norms.hpp"
#include "phistep/state/parts.hpp"
#include "phistep/step/error_law.hpp"
#include "phistep/step/scheme_set.hpp"
#include "phistep/step/scheme_uses.hpp"
#include "phistep/step/stiffness_watch.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Steps a state S under a force F by the scheme that suits, as long as it does.
template <State S, class F, class MassSpec = UnitMasses>
class AutomaticStepper {
  using Schemes = SchemesFor<S, F, MassSpec>;
  using Set = typename Schemes::Set;
  using Steppers = typename Schemes::Steppers;
  static_assert(
      !Schemes::Rhs::has_history,
      "phistep: no scheme is chosen for a force with a history (contacts, friction): it wants steps that resolve an "
      "impact, of equal length; take PhiStepper{..., velocity_verlet} with fixed(dt), phistep::preflight says how "
      "long");

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using StateType = S;
  static constexpr const char* part_name = "stepper";
  using Checkpoint = typename CheckpointOfAny<Steppers>::type;

  /// @param state  gives the sizes; views are kept, other states are not
  /// @param force  copied for each scheme that is taken; wrap it in std::ref to keep it outside
  /// @param rtol   that its runs will be asked for: which scheme is best depends on it
  /// @param mass   mass(m) or capacity(C); M = 1 if left out
  AutomaticStepper(const S& state, F force, double rtol, MassSpec mass = {})
      : AutomaticStepper{plain_of(state), state, std::move(force), rtol, std::move(mass)} {}

  /// A step at a given Δt, by the scheme at work. [time]
  StepReport step(S& state, Scalar t, Scalar dt, Origin origin = Origin::unknown) {
    return visit(*this, [&](auto& scheme) { return scheme.step(state, t, dt, origin); });
  }

  /// Where a run begins, its first step proposed: takes an implicit scheme where that step says stiff. Of the first run only.
  /// @param pace  of the run. @return whether it did: the first step is then to be proposed anew
  [[nodiscard]] bool begin_run(const S& state, const Plain& y, const RunClock<Scalar>& clock, auto& pace) {
    if (course_.is_bound || !course_.at_start) return false;
    const RateSeen seen = look_at_rate(y, clock, pace);
    course_.at_start = false;
    return course_.watch.starts_stiff(seen) && change(state, clock.t(), seen, true);
  }
  /// Before each step of a run: looks whether another scheme would serve better, and takes it.
  /// @return [time] the longest step that a new scheme should begin with, nothing where it stays
  [[nodiscard]] std::optional<double> choose(const S& state, const Plain& y, const RunClock<Scalar>& clock,
                                             auto& pace) {
    if (course_.is_bound || course_.done == 0) return {};
    course_.watch.accepted(pace.propose());
    course_.steps += std::exchange(course_.done, 0);
    if (!course_.watch.is_due()) return {};
    const RateSeen seen = look_at_rate(y, clock, pace);
    if (!course_.watch.judge(seen) || !change(state, clock.t(), seen, false)) return {};
    return course_.watch.is_implicit() ? seen.dt : course_.watch.stable_step(seen.rate);
  }
  /// The number of the scheme at work.
  [[nodiscard]] int active() const { return static_cast<int>(steppers_.index()); }
  [[nodiscard]] SuitableScheme scheme() const { return Set::all[steppers_.index()]; }
  /// What it took, when and why.
  [[nodiscard]] const SchemeUses& uses() const { return course_.uses; }
  /// The last look at the rate.
  [[nodiscard]] const RateSeen& seen() const { return seen_; }
  /// Whether it is, or would be if it could, at an implicit scheme.
  [[nodiscard]] bool is_stiff() const { return course_.watch.is_implicit() || is_kept_explicit_; }

  // What a run controlled by its error asks beside steps: what the scheme at work can tell.
  static constexpr StepperFacts facts{.traces = true,
                                      .interpolates = true,
                                      .is_sure_inside = false,
                                      .solves_nothing = false,
                                      .reads_weights = true,
                                      .refactorizes = false,
                                      .is_affine = false,
                                      .doubtful_at = usually_doubtful};
  [[nodiscard]] bool estimates(const Trace<Plain>& trace) const {
    return visit(*this, [&](auto& scheme) { return scheme.estimates(trace); });
  }
  template <class Accept>
  StepReport attempt(S& state, Scalar t, Scalar dt, Origin origin, Trace<Plain>& trace, Accept&& accept) {
    const StepReport report =
        visit(*this, [&](auto& scheme) { return scheme.attempt(state, t, dt, origin, trace, accept); });
    if (report) ++course_.done;
    else if (report.outcome() == Outcome::error_too_large) course_.watch.rejected();
    return report;
  }
  /// As PhiStepper's; false, too, where the scheme at work has no interpolant of its own.
  [[nodiscard]] bool know_inside(Scalar dt, const Plain& y0) {
    return visit(*this, [&]<class Stepper>(Stepper& scheme) {
      if constexpr (facts_of<Stepper>.interpolates) return scheme.know_inside(dt, y0);
      else return false;
    });
  }
  void interpolate(Scalar x, Scalar dt, const Plain& y0, const Plain& y1, Plain& out) const {
    visit(*this, [&]<class Stepper>(Stepper& scheme) {
      if constexpr (facts_of<Stepper>.interpolates) scheme.interpolate(x, dt, y0, y1, out);
    });
  }
  [[nodiscard]] bool is_sure_inside() const {
    return visit(*this, []<class Stepper>(Stepper&) -> bool { return facts_of<Stepper>.is_sure_inside; });
  }
  [[nodiscard]] friend ErrorLaw error_law(const AutomaticStepper& stepper) {
    return visit(stepper, [](auto& scheme) { return error_law(scheme); });
  }
  [[nodiscard]] int order() const {
    return visit(*this, [](auto& scheme) { return scheme.order(); });
  }
  [[nodiscard]] int error_order() const {
    return visit(*this, [](auto& scheme) { return scheme.error_order(); });
  }
  /// out = y' at (t, y): one force call; false where it isn't finite.
  [[nodiscard]] bool slope(Scalar t, const Plain& y, Plain& out) {
    return visit(*this, [&](auto& scheme) { return scheme.slope(t, y, out); });
  }
  void complete_slopes(const Plain& y0, const Plain& y1, Scalar dt, Plain& slope0, Plain& slope1) const {
    visit(*this, [&](auto& scheme) { scheme.complete_slopes(y0, y1, dt, slope0, slope1); });
  }
  [[nodiscard]] const Failure& history() const {
    return visit(*this, [](auto& scheme) -> const Failure& { return scheme.history(); });
  }
  [[nodiscard]] const char* solver_name() const {
    return visit(*this, [](auto& scheme) { return scheme.solver_name(); });
  }
  [[nodiscard]] bool keeps_factors() const {
    return visit(*this, [](auto& scheme) { return scheme.keeps_factors(); });
  }
  /// Of all schemes that were at work.
  [[nodiscard]] Statistics statistics() const {
    return course_.retired + visit(*this, [](auto& scheme) -> Statistics { return scheme.statistics(); });
  }
  [[nodiscard]] std::int64_t changes() const {
    return course_.changes + visit(*this, [](auto& scheme) { return scheme.changes(); });
  }
  /// The force of the scheme at work, to be called and not to be changed.
  [[nodiscard]] auto& force_to_look_at() {
    return visit(
        *this, [](auto& scheme) -> auto& { return scheme.force_to_look_at(); });
  }

  [[nodiscard]] Checkpoint checkpoint() const {
    return visit(*this, [](auto& scheme) -> Checkpoint { return scheme.checkpoint(); });
  }
  /// To a point since which the scheme has not changed.
  void restore(Checkpoint checkpoint) {
    visit(*this, [&]<class Stepper>(Stepper& scheme) {
      using Past = typename Stepper::Checkpoint;
      scheme.restore(std::get<Past>(std::move(checkpoint)));
    });
  }
  void forget_solves() {
    visit(*this, [](auto& scheme) { scheme.forget_solves(); });
  }
  void forget_unsaved() {
    visit(*this, []<class Stepper>(Stepper& scheme) {
      if constexpr (HasUnsaved<Stepper>) scheme.forget_unsaved();
    });
  }
  /// Forgets all that is carried from step to step; the scheme at work stays.
  void reset() {
    visit(*this, [](auto& scheme) { scheme.reset(); });
  }
  /// As PhiStepper's, with which scheme is at work, and what led to it.
  void save(Writer& out) const {
    save_parts(out, "active", active(), "course", course_);
    out.open("scheme");
    visit(*this, [&out](auto& scheme) { scheme.save(out); });
    out.close();
  }
  void load(Reader& in, auto&& then) {
    int active = 0;
    Course course = course_;
    in("active", active, "course", course);
    in.check(0 <= active && active < static_cast<int>(Set::all.size()));
    Steppers fresh = make(active, sample());
    std::visit(
        [&](auto& scheme) {
          in.open("scheme");
          scheme.load(in, [&] {
            in.close();
            then();
          });
        },
        fresh);
    steppers_ = std::move(fresh);
    course_ = std::move(course);
  }

 private:
  /// What a checkpoint holds beside the scheme at work.
  struct Course {
    StiffnessWatch watch;
    SpectralRadius<Plain> radius;
    Plain before;          ///< y' at the last look
    bool is_bound;         ///< to the scheme at work
    bool at_start = true;  ///< of the first run
    bool knows_before = false;
    SchemeUses uses{};
    Statistics retired{};              ///< of the schemes before
    std::int64_t changes = 0;          ///< of the forces of these
    std::int64_t steps = 0, done = 0;  ///< steps seen, steps since
    void archive(auto& ar) {
      ar("watch", watch, "uses", uses, "radius", radius, "retired", retired, "steps", steps, "done", done, "changes",
         changes, "knows_before", knows_before, "at_start", at_start, "is_bound", is_bound);
      ar.in_place("before", before);
      ar.check(can_be_count(steps) && can_be_count(done));
    }
  };

  AutomaticStepper(Plain&& copy, const S& state, F&& force, double rtol, MassSpec&& mass)
      : force_{std::move(force)},
        mass_{std::move(mass)},
        problem_{problem_of(copy, mass_, rtol)},
        course_{.watch = StiffnessWatch{rivals()},
                .radius = SpectralRadius<Plain>{copy},
                .before = copy,
                .is_bound = is_singular(bind_masses<S>(mass_, copy))},
        steppers_{make(course_.is_bound ? implicit_index() : explicit_index(), state)},
        view_{state} {
    course_.uses.add({.scheme = scheme(), .cause = course_.is_bound ? SchemeCause::algebraic : SchemeCause::start});
  }
  [[nodiscard]] static AdvisedProblem problem_of(const Plain& y, const MassSpec& mass, double rtol) {
    AdvisedProblem problem = scene_of<S, F>(y, mass);
    problem.rtol = rtol;
    return problem;
  }
  [[nodiscard]] RivalSteps rivals() const {
    const SuitableScheme taken = Set::all[at(explicit_index())];
    return {stability_bound(taken), step_cost(taken, problem_), step_cost(Set::all[at(implicit_index())], problem_)};
  }
  [[nodiscard]] static Plain plain_of(const S& state) {
    Plain copy;
    copy_blocks<S>(copy, state);
    return copy;
  }

  [[nodiscard]] static std::size_t at(int k) { return static_cast<std::size_t>(k); }
  [[nodiscard]] int explicit_index() const {
    const int k = Set::index_of(suitable_explicit(problem_).scheme, 0);
    return k < Schemes::explicit_schemes ? k : 0;
  }
  /// The scheme of the rules, or the last where that is not compiled.
  [[nodiscard]] int implicit_index() const {
    constexpr int first = Schemes::explicit_schemes, last = static_cast<int>(Set::all.size()) - 1;
    AdvisedProblem problem = problem_;
    problem.has_jacobian = problem.has_jacobian || can_be_implicit();
    const int k = Set::index_of(suitable_implicit(problem).scheme, last);
    return k < first ? last : k;
  }
  /// Whether there can be a matrix.
  [[nodiscard]] bool can_be_implicit() const {
    return problem_.has_jacobian || problem_.has_pattern || problem_.unknowns <= dense_difference_limit;
  }
  [[nodiscard]] Steppers make(int k, const S& state) const { return make_from<0>(at(k), state); }
  template <std::size_t i>
  [[nodiscard]] Steppers make_from(std::size_t k, const S& state) const {
    if constexpr (i + 1 < Set::all.size())
      if (k != i) return make_from<i + 1>(k, state);
    return Steppers{std::in_place_index<i>, state, force_, scheme_named<Set::all[i]>(), mass_};
  }
  /// f(the stepper at work)
  template <std::size_t i = 0>
  [[gnu::always_inline]] static inline decltype(auto) visit(auto& self, auto&& f) {
    if constexpr (i + 1 < Set::all.size())
      if (self.steppers_.index() != i) return visit<i + 1>(self, f);
    return f(*std::get_if<i>(&self.steppers_));
  }

  /// The rate at (t, y), in the weights of the run: its direction is the error's where that is stiffness's, else the last one's.
  [[nodiscard]] RateSeen look_at_rate(const Plain& y, const RunClock<Scalar>& clock, auto& pace) {
    if (!same_shape<Plain>(course_.before, y)) {
      course_.radius = SpectralRadius<Plain>{y};
      course_.before = y;
      course_.knows_before = false;
    }
    auto& trace = pace.trace();
    const double rtol = pace.weigh(y, trace.weight);
    if (!course_.at_start && !course_.watch.is_implicit()) course_.radius.start_along(trace.error, trace.weight);
    const auto slope = [this](Scalar t, const Plain& x, Plain& out) { return this->slope(t, x, out); };
    RateSeen seen;
    seen.rate = course_.radius(slope, clock.t(), y, trace.weight, rtol, course_.at_start ? 2 : 1);
    seen.dt = pace.propose();
    seen.left = std::abs(static_cast<double>(clock.length_to(clock.span().t1)));
    const Plain& now = course_.radius.slope();
    if (course_.knows_before) {
      const double size = std::max(weighted_rms(now, trace.weight), weighted_rms(course_.before, trace.weight));
      assign<Plain>(course_.before, in<Plain>(course_.before) - in<Plain>(now));
      if (size > 0) seen.change = weighted_rms(course_.before, trace.weight) / size;
    }
    copy_blocks<Plain>(course_.before, now);
    course_.knows_before = true;
    return seen_ = seen;
  }
  /// Takes the scheme of the other kind, if it can.
  [[nodiscard]] bool change(const S& state, Scalar t, const RateSeen& seen, bool at_start) {
    const bool to_implicit = !course_.watch.is_implicit();
    SchemeUse use{
        .scheme = scheme(), .t = static_cast<double>(t), .step = course_.steps, .rate = seen.rate, .dt = seen.dt};
    if (to_implicit && !can_be_implicit()) {
      use.cause = SchemeCause::stays_explicit;
      course_.is_bound = is_kept_explicit_ = true;
      course_.uses.add(use);
      return false;
    }
    Steppers fresh = make(to_implicit ? implicit_index() : explicit_index(), state);
    course_.retired = statistics();
    course_.changes = changes();
    steppers_ = std::move(fresh);
    if (at_start) course_.watch.begin_implicit();
    else course_.watch.change();
    use.scheme = scheme();
    use.cause = at_start ? SchemeCause::stiff_start : to_implicit ? SchemeCause::stiff : SchemeCause::eased;
    course_.uses.add(use);
    return true;
  }
  /// A state of the right sizes.
  [[nodiscard]] const S& sample() const {
    if constexpr (is_view) return view_;
    else return course_.before;
  }

  struct Nothing {
    explicit Nothing(const auto&) {}
  };
  static constexpr bool is_view = !std::is_same_v<S, Plain>;

  F force_;
  [[no_unique_address]] MassSpec mass_;
  AdvisedProblem problem_;
  Course course_;
  Steppers steppers_;
  [[no_unique_address]] std::conditional_t<is_view, S, Nothing> view_;
  RateSeen seen_;
  bool is_kept_explicit_ = false;
};

template <class S, class F>
AutomaticStepper(const S&, F, double) -> AutomaticStepper<S, F>;
template <class S, class F>
AutomaticStepper(const S&, F, double, UnitMasses) -> AutomaticStepper<S, F>;
template <class S, class F, class... M>
AutomaticStepper(const S&, F, double, MassList<M...>) -> AutomaticStepper<S, F, MassList<M...>>;

}  // namespace phistep::inline PHISTEP_ABI
