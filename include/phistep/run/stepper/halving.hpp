/// @file
/// A stepper around a stepper: where a step fails for a reason that a smaller one may cure, it is done as two half steps,
/// each of them, if need be, as two quarter steps, and so on; all of it or nothing.
///
///     phistep::Halving stepper{phistep::PhiStepper{cloth, springs, phistep::backward_euler}, 10};
///
/// With Newton's fresh Jacobian, which is tried first, this is the ladder of retries: old matrix, new matrix, Δt/2, Δt/4, …
///
/// Where a tolerance controls Δt, a step that fails is tried again with a shorter one as it is: then the stepper inside does
/// each step, with its own error estimate, dense output and counts.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "phistep/base/archive/archive_kinds.hpp"
#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/base/version.hpp"
#include "phistep/run/stepper/any_stepper.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A stepper that does a failed step again as two half steps, these as quarter steps, and so on: all of it or nothing.
template <class Stepper>
class Halving {
 public:
  using ArchivedByParts = void;
  static constexpr const char* part_name = "stepper";
  /// @param halvings  the smallest step tried is Δt/2^halvings
  /// @throws std::invalid_argument where halvings is negative
  explicit Halving(Stepper stepper, int halvings = 10) : stepper_{std::move(stepper)}, deepest_{halvings} {
    if (halvings < 0) throw std::invalid_argument("phistep: Halving needs a number of halvings >= 0");
  }

  /// Advances the state from t to t + dt. [time] On failure the state and the force's history keep every bit, and the
  /// report is that of the smallest step that failed; an exception thrown by the force passes through, likewise.
  template <class S>
  StepReport step(S& state, ScalarOf<S> t, ScalarOf<S> dt, Origin origin = Origin::unknown) {
    const StepReport whole = do_step(stepper_, state, t, dt, origin);
    if (whole) ++steps_;
    if (whole || deepest_ == 0 || !may_be_cured(whole.outcome()) || first_non_finite(Blocks<S>::all(state)))
      return counted(whole);

    PlainState<S> start;
    copy_blocks<S>(start, state);
    Past<Stepper> past = past_of(stepper_);
    const std::int64_t halvings = halvings_;
    int iterations = whole.iterations();
    // It must not allocate: for want of memory may be why.
    const auto take_back = [&] {
      copy_blocks<S>(state, start);
      go_back(stepper_, std::move(past));
      halvings_ = halvings;
    };
    try {
      const StepReport halved = halve(state, t, dt, origin, 1, iterations);
      if (halved) return ++steps_, StepReport{Outcome::success, iterations, nullptr};
      take_back();
      return counted(halved);
    } catch (...) {
      take_back();
      throw;
    }
  }

  [[nodiscard]] int order() const { return stepper_.order(); }

  // What a run controlled by its error asks beside steps: all that the stepper inside can tell.
  static constexpr StepperFacts facts{.traces = facts_of<Stepper>.traces,
                                      .interpolates = facts_of<Stepper>.interpolates,
                                      .is_sure_inside = facts_of<Stepper>.is_sure_inside,
                                      .solves_nothing = facts_of<Stepper>.solves_nothing,
                                      .reads_weights = facts_of<Stepper>.reads_weights,
                                      .refactorizes = facts_of<Stepper>.refactorizes,
                                      .is_affine = facts_of<Stepper>.is_affine,
                                      .doubtful_at = facts_of<Stepper>.doubtful_at};
  template <class Plain>
  [[nodiscard]] bool estimates(const Trace<Plain>& trace) const requires(facts.traces.value) {
    return stepper_.estimates(trace);
  }
  template <class S, class Accept>
  StepReport attempt(S& state, ScalarOf<S> t, ScalarOf<S> dt, Origin origin, Trace<PlainState<S>>& trace,
                     const Accept& accept) requires(facts.traces.value) {
    const StepReport report = stepper_.attempt(state, t, dt, origin, trace, accept);
    if (report) ++steps_;
    else if (report.outcome() != Outcome::error_too_large) ++failed_steps_;
    return report;
  }
  template <class Plain, class Scalar>
  [[nodiscard]] bool know_inside(Scalar dt, const Plain& y0) requires(facts.interpolates.value) {
    return stepper_.know_inside(dt, y0);
  }
  template <class Plain, class Scalar>
  void interpolate(Scalar x, Scalar dt, const Plain& y0, const Plain& y1, Plain& out) const
      requires(facts.interpolates.value) {
    stepper_.interpolate(x, dt, y0, y1, out);
  }
  [[nodiscard]] int error_order() const requires requires(const Stepper& inner) { inner.error_order(); }
  { return stepper_.error_order(); }
  [[nodiscard]] std::int64_t changes() const requires requires(const Stepper& inner) { inner.changes(); }
  { return stepper_.changes(); }
  template <class Plain, class Scalar>
  [[nodiscard]] bool slope(Scalar t, const Plain& y, Plain& out) {
    return stepper_.slope(t, y, out);
  }
  [[nodiscard]] const SolveRecord& last_solve() const { return stepper_.last_solve(); }
  [[nodiscard]] const char* solver_name() const { return stepper_.solver_name(); }
  [[nodiscard]] bool keeps_factors() const requires requires(const Stepper& inner) { inner.keeps_factors(); }
  { return stepper_.keeps_factors(); }
  /// Steps are those asked for; each halving is one more that was made. All other counts are of the work done.
  [[nodiscard]] Statistics statistics() const {
    Statistics all = stepper_.statistics();
    all.steps = steps_;
    all.failed_steps = failed_steps_;
    all.halvings = halvings_;
    return all;
  }
  /// The stepper inside.
  [[nodiscard]] Stepper& stepper() { return stepper_; }
  [[nodiscard]] const Stepper& stepper() const { return stepper_; }
  void reset() { stepper_.reset(); }
  [[nodiscard]] auto& kept_sizes() requires requires(Stepper& inner) { inner.kept_sizes(); }
  { return stepper_.kept_sizes(); }
  /// As PhiStepper's.
  void forget_solves() requires requires(Stepper& inner) { inner.forget_solves(); }
  { stepper_.forget_solves(); }
  /// As PhiStepper's: to reject a step restores the force's history too.
  [[nodiscard]] auto checkpoint() const requires requires(const Stepper& inner) { inner.checkpoint(); }
  { return stepper_.checkpoint(); }
  void restore(auto past) requires requires(Stepper& inner) { inner.restore(std::move(past)); }
  { stepper_.restore(std::move(past)); }
  /// As PhiStepper's.
  void forget_unsaved() requires HasUnsaved<Stepper> { stepper_.forget_unsaved(); }
  void archive(auto& ar) {
    std::array counts{steps_, failed_steps_, halvings_};
    ar.aside("counts", counts);
    for (const std::int64_t count : counts) ar.check(can_be_count(count));
    ar("stepper", stepper_);
    ar.at_last([this, counts] { steps_ = counts[0], failed_steps_ = counts[1], halvings_ = counts[2]; });
  }

 private:
  /// Both halves of a step that failed as a whole.
  template <class S, class Scalar>
  StepReport halve(S& state, Scalar t, Scalar dt, Origin origin, int depth, int& iterations) {
    ++halvings_;
    const Scalar half = dt / 2;
    const StepReport first = part(state, t, half, origin.first_part(), depth, iterations);
    return first ? part(state, t + half, half, origin.last_part().with(origin.edits), depth, iterations) : first;
  }
  template <class S, class Scalar>
  StepReport part(S& state, Scalar t, Scalar dt, Origin origin, int depth, int& iterations) {
    const StepReport report = do_step(stepper_, state, t, dt, origin);
    iterations += report.iterations();
    if (report || depth == deepest_ || !may_be_cured(report.outcome())) return report;
    return halve(state, t, dt, origin, depth + 1, iterations);
  }

  StepReport counted(const StepReport& report) {
    failed_steps_ += report ? 0 : 1;
    return report;
  }

  Stepper stepper_;
  int deepest_;
  std::int64_t steps_ = 0, failed_steps_ = 0, halvings_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
