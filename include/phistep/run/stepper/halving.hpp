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
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/run/errors/step_filter.hpp"
#include "phistep/run/stepper/any_stepper.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A stepper that does a failed step again as two half steps, these as quarter steps, and so on: all of it or nothing. All that a
/// run asks beside steps is the stepper's inside, from which it derives.
template <class Stepper>
class Halving : public Stepper {
 public:
  using ArchivedByParts = void;
  static constexpr const char* part_name = "stepper";
  static constexpr StepperFacts facts = [] {
    StepperFacts inside = facts_of<Stepper>;
    inside.takes_several = false;
    return inside;
  }();
  /// @param halvings  the smallest step tried is Δt/2^halvings
  /// @throws std::invalid_argument where halvings is negative
  explicit Halving(Stepper stepper, int halvings = 10) : Stepper{std::move(stepper)}, deepest_{halvings} {
    if (halvings < 0) throw std::invalid_argument("phistep: Halving needs a number of halvings >= 0");
  }

  /// Advances the state from t to t + dt. [time] On failure the state and the force's history keep every bit, and the
  /// report is that of the smallest step that failed; an exception thrown by the force passes through, likewise.
  template <class S>
  StepReport step(S& state, ScalarOf<S> t, ScalarOf<S> dt, Origin origin = Origin::unknown) {
    const StepReport whole = do_step(stepper(), state, t, dt, origin);
    if (whole) ++steps_;
    if (whole || deepest_ == 0 || !may_be_cured(whole.outcome()) || first_non_finite(Blocks<S>::all(state)))
      return counted(whole);

    PlainState<S> start;
    copy_blocks<S>(start, state);
    Past<Stepper> past = past_of(stepper());
    const std::int64_t halvings = halvings_;
    int iterations = whole.iterations();
    // It must not allocate: for want of memory may be why.
    const auto take_back = [&] {
      copy_blocks<S>(state, start);
      go_back(stepper(), std::move(past));
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

  template <class S>
  StepReport attempt(S& state, ScalarOf<S> t, ScalarOf<S> dt, Origin origin, Trace<PlainState<S>>& trace,
                     const Judge<PlainState<S>>& accept) requires(facts_of<Stepper>.traces.value) {
    const StepReport report = stepper().attempt(state, t, dt, origin, trace, accept);
    if (report) ++steps_;
    else if (report.outcome() != Outcome::error_too_large) ++failed_steps_;
    return report;
  }
  /// Steps are those asked for; each halving is one more that was made. All other counts are of the work done.
  [[nodiscard]] Statistics statistics() const {
    Statistics all = stepper().statistics();
    all.steps = steps_;
    all.failed_steps = failed_steps_;
    all.halvings = halvings_;
    return all;
  }
  /// The stepper inside.
  [[nodiscard]] Stepper& stepper() { return *this; }
  [[nodiscard]] const Stepper& stepper() const { return *this; }
  [[nodiscard]] friend ErrorLaw error_law(const Halving& outer) { return error_law(outer.stepper()); }
  void archive(auto& ar) {
    std::array counts{steps_, failed_steps_, halvings_};
    ar.aside("counts", counts);
    for (const std::int64_t count : counts) ar.check(can_be_count(count));
    ar("stepper", stepper());
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
    const StepReport report = do_step(stepper(), state, t, dt, origin);
    iterations += report.iterations();
    if (report || depth == deepest_ || !may_be_cured(report.outcome())) return report;
    return halve(state, t, dt, origin, depth + 1, iterations);
  }

  StepReport counted(const StepReport& report) {
    failed_steps_ += report ? 0 : 1;
    return report;
  }

  int deepest_;
  std::int64_t steps_ = 0, failed_steps_ = 0, halvings_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
