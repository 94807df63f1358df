/// @file
/// A step is a transaction: it works beside the state, then commits everything or leaves everything as it was.
#pragma once

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/archive/archive_kinds.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/copy_views.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/transaction/edit_guard.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Runs a scheme's step on a state of type S. `carries`: the scheme may leave Ψ⁺ behind.
template <State S, class Rhs, bool carries>
class Transaction {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;

  /// @throws std::invalid_argument where r and v of a motion differ in shape, or views share memory
  /// @param copy  of the state
  Transaction(const S& state, const Plain& copy) : next_{copy}, psi_{make_rate<S>(next_)} {
    if constexpr (borrowed && !ShowsTrials<S>) {
      if (!has_own_places(state))
        throw std::invalid_argument(
            "phistep: the state's views share memory: each of its numbers needs a place of its own");
      gathered_ = next_;
    }
    if constexpr (carries) guard_.reserve(next_);
  }

  /// A step begins: success, or why it can't.
  [[nodiscard]] Outcome open(Scalar t, Scalar dt) {
    record_.begin();
    if (!(std::isfinite(dt) && std::isfinite(t)) || dt == Scalar{0}) return Outcome::invalid_step;
    return t + dt == t ? Outcome::step_too_small : Outcome::success;
  }
  /// A step that did not begin.
  StepReport refuse(Rhs& rhs, Outcome why, Scalar t, Scalar dt) { return fail(rhs, why, t, dt, next_, next_, psi_); }
  /// For a step done elsewhere that failed: notes what it had come to.
  void show_end(const S& state, const auto& psi) {
    end_ = first_non_finite(Blocks<S>::all(state));
    assign_block(std::get<0>(Rate::blocks(psi_)), psi);
  }
  /// The report of that step, once the state is put back.
  StepReport report_shown(Rhs& rhs, Outcome outcome, Scalar t, Scalar dt, const S& state) {
    copy_blocks<S>(next_, state);
    const StepReport report = fail(rhs, outcome, t, dt, next_, next_, psi_);
    if (failure_.block < 0) static_cast<ComponentLocation&>(failure_) = end_;
    return report;
  }

  /// @param steps     OneStep or, where takes_several, GridSteps (run/control/fixed_step.hpp): t(n), dt, count(); the same bits as by a
  ///                  call for each
  /// @param equation_of  (y, t, dt, next, psi, masses, whether psi is Ψ(t, y)) → the equation of a step
  /// @param advance   (equation) → Outcome
  /// @param accepted  called after each
  StepReport take(Rhs& rhs, S& state, const auto& steps, Origin origin, auto& equation_of, auto& advance,
                  auto& accepted) {
    if (const Outcome bad = open(steps.t(0), steps.dt); failed(bad)) return refuse(rhs, bad, steps.t(0), steps.dt);
    const std::int64_t before = rhs.statistics().steps;
    try {
      // Takes trial states back out of the user's arrays, unless the step is done; after an exception as well.
      [[maybe_unused]] bool is_done = false;
      [[maybe_unused]] const AtExit held{[&] {
        if constexpr (ShowsTrials<S>) {
          if (!is_done) state.put_back();
          state.release();
        }
      }};
      if constexpr (in_registers) {
        static_assert(!ShowsTrials<S>);
        Plain y = read(state), next;
        Rate psi;
        if constexpr (carries) psi = psi_;
        else set_zero(Rate::blocks(psi));  // a message may tell of it before it is written
        return take_from(rhs, y, state, steps, origin, equation_of, advance, accepted, next, psi);
      } else {
        const Plain& y = read(state);
        const StepReport report = take_from(rhs, y, state, steps, origin, equation_of, advance, accepted, next_, psi_);
        is_done = static_cast<bool>(report);
        return report;
      }
    } catch (const WrongSize& wrong) {
      copy_blocks<S>(next_, state);
      const Scalar t = steps.t(rhs.statistics().steps - before);
      return fail(rhs, Outcome::wrong_size, t, steps.dt, next_, next_, psi_, &wrong);
    }
  }

  /// Outcome::inconsistent_start will be about this component.
  void set_inconsistent(const ComponentLocation& component) { inconsistent_ = component; }
  /// What the solves of this step have done, or those of the last.
  [[nodiscard]] SolveRecord& record() { return record_; }
  [[nodiscard]] const SolveRecord& record() const { return record_; }
  void reset() { guard_.forget(); }
  [[nodiscard]] bool fits(const S& state) const {
    if constexpr (HasProperties<S>)
      if (!S::same_properties(state, next_)) return false;
    return same_shape<S>(state, next_);
  }
  /// For a checkpoint: Ψ, and where it holds.
  void archive(auto& ar) {
    ar("known_at", guard_);
    ar.in_place("value", psi_);
  }
  /// What states it is for, in words.
  [[nodiscard]] std::string shape() const {
    std::string all;
    for_each_block(
        [&all](auto, const auto& block) {
          all += (all.empty() ? "" : ", ") + std::to_string(block.rows()) + " x " + std::to_string(block.cols());
        },
        Blocks<S>::all(next_));
    return all + " of " + detail::kind_of<Scalar>().words();
  }
  /// Small fixed states live in registers during the step: a workspace in memory doubles the cost of a bare update.
  static constexpr bool in_registers = fits_registers<S>;
  /// Steps without anything between them: not where others may write into the state's places.
  static constexpr bool takes_several = std::is_same_v<S, Plain> && !ShowsTrials<S>;
  [[nodiscard]] static Plain copy_of(const S& state) {
    Plain copy;
    copy_blocks<S>(copy, state);
    if constexpr (Blocks<S>::drifts) {
      const auto &r = std::get<0>(Blocks<S>::all(copy)), &v = std::get<1>(Blocks<S>::all(copy));
      if (r.rows() != v.rows() || r.cols() != v.cols())
        throw std::invalid_argument("phistep: the positions and velocities of a motion differ in size");
    }
    return copy;
  }

 private:
  static_assert(!FieldState<S> || count_of_fields<decltype(Blocks<S>::all(std::declval<S&>()))> ==
                                      std::tuple_size_v<decltype(Blocks<S>::all(std::declval<S&>()))>,
                "phistep: a state is of fields or of Eigen's vectors, not of both");
  /// A Map or Ref refers to the user's memory: it is read once, and written at the commit.
  static constexpr bool borrowed = !std::is_same_v<S, Plain>;

  /// With a small state goes a copy of its masses, or each step would divide by them anew: what is written to a state might be
  /// theirs, for all that the compiler knows.
  using Masses = std::conditional_t<in_registers && std::is_trivially_copy_constructible_v<typename Rhs::Masses>,
                                    const typename Rhs::Masses, const typename Rhs::Masses&>;

  [[nodiscard]] const Plain& read(S& state) {
    if constexpr (ShowsTrials<S>) {
      return state.hold();
    } else if constexpr (borrowed) {
      if constexpr (in_registers) copy_blocks<S>(gathered_, state);
      else copy_views<S>(gathered_, state);
      return gathered_;
    } else {
      return state;
    }
  }

  StepReport take_from(Rhs& rhs, auto& y, S& state, const auto& steps, Origin origin, auto& equation_of, auto& advance,
                       auto& accepted, Plain& next, Rate& psi) {
    bool knows_start = false;
    rhs.limit_times(steps.t(0), steps.dt, origin);
    if constexpr (carries) {
      const Scalar at = rhs.inside(steps.t(0));
      knows_start = origin == Origin::unedited ? guard_.holds_unedited(at) : guard_.holds(at, y);
      guard_.forget();  // an exception from here on leaves psi half-written
    }
    Masses masses = rhs.masses();
    for (std::int64_t n = 0;;) {
      const Scalar t = steps.t(n), dt = steps.dt;
      rhs.begin(t, dt, y);
      auto equation = equation_of(y, t, dt, next, psi, masses, knows_start);
      const Outcome outcome = advance(equation);
      if (outcome != Outcome::success) {
        if (outcome == Outcome::error_too_large) {
          ++rhs.statistics().rejections;
          return {outcome, record_.iterations, nullptr};
        }
        if constexpr (in_registers) {
          // fail() must not see addresses of what should stay in registers on the good path: it gets copies.
          const Plain copy = y;
          next_ = next;
          psi_ = psi;
          return fail(rhs, outcome, t, dt, copy, next_, psi_);
        }
        return fail(rhs, outcome, t, dt, y, next_, psi_);
      }
      rhs.commit(t + dt, next);
      knows_start = carries && equation.knows_end;
      const bool is_last = ++n == steps.count();
      if constexpr (carries)
        if (is_last && knows_start) {
          if constexpr (in_registers) psi_ = psi;
          if (origin == Origin::unedited) guard_.remember_unchecked(rhs.inside(t + dt));
          else guard_.remember(rhs.inside(t + dt), next);
        }
      if constexpr (borrowed && !in_registers && !ShowsTrials<S>) {
        if (!equation.is_state_next) copy_views<S>(state, std::as_const(next));
      } else if (!equation.is_state_next) {
        commit_blocks<S>(state, next);
      }
      ++rhs.statistics().steps;
      accepted();
      if (is_last) return {Outcome::success, record_.iterations, nullptr};
      if constexpr (in_registers) y = next;
    }
  }

  // Out of line: the compiler must not weigh this against inlining the step itself.
  [[gnu::cold, gnu::noinline]] StepReport fail(Rhs& rhs, Outcome outcome, Scalar t, Scalar dt, const Plain& y,
                                               const Plain& next, const Rate& psi, const WrongSize* wrong = nullptr) {
    ++rhs.statistics().failed_steps;
    Failure& f = failure_;
    static_cast<SolveRecord&>(f) = record_;
    f.returned_rows = wrong != nullptr ? wrong->rows : -1;
    f.returned_columns = wrong != nullptr ? wrong->columns : -1;
    f.t = static_cast<double>(t);
    f.dt = static_cast<double>(dt);
    f.term = -1;
    ComponentLocation where;
    // Where the force has thrown it is NaN.
    if constexpr (FieldState<S>) {
      if (const Outcome found = agreed(y, rhs.held()->found()); failed(found)) outcome = found;
      rhs.held()->told();
    }
    if (outcome == Outcome::wrong_size) f.term = rhs.offending_term(t, y);
    if (outcome == Outcome::non_finite_state || outcome == Outcome::non_finite_force) {
      if (where = first_non_finite(Blocks<S>::all(y)); where) {
        outcome = Outcome::non_finite_state;
      } else if (where = first_non_finite(Rate::blocks(psi)); where || rhs.is_non_finite_at(t, y, where)) {
        outcome = Outcome::non_finite_force;
        where.block += Blocks<S>::drifts ? 1 : 0;
        f.term = rhs.offending_term(t, y);
        if (f.term < 0 && is_seen_finite(next)) f.term = rhs.offending_term(t + dt, next);
      } else {
        where = first_non_finite(Blocks<S>::all(next));
      }
      // Cleared: must not appear in the next failure report.
      set_zero(Rate::blocks(psi_));
    }
    if (outcome == Outcome::inconsistent_start) where = inconsistent_;
    f.outcome = outcome;
    static_cast<ComponentLocation&>(f) = where;
    if constexpr (FieldState<S>) rhs.held()->rethrow();
    return {outcome, f.iterations, &f};
  }

  /// Whether a force sees finite numbers at y. Elsewhere any term is NaN, and the first would be blamed.
  [[nodiscard]] static bool is_seen_finite(const Plain& y) {
    constexpr bool sees_r_alone =
        Blocks<S>::drifts && !Rhs::couples_unknowns && std::is_same_v<typename Rhs::Force, typename Rhs::Whole>;
    if constexpr (sees_r_alone) return !first_non_finite(std::tie(std::get<0>(Blocks<S>::all(y))));
    else return !first_non_finite(Blocks<S>::all(y));
  }

  Plain next_;
  Rate psi_;
  [[no_unique_address]] Only<borrowed && !ShowsTrials<S>, Plain> gathered_;
  EditGuard<S, Blocks<S>::drifts && !Rhs::couples_unknowns, Rhs::Traits::uses_time> guard_;
  SolveRecord record_;
  Failure failure_;  // of the step that failed last
  ComponentLocation inconsistent_;
  [[no_unique_address]] Only<ShowsTrials<S>, ComponentLocation> end_;
};

}}  // namespace phistep::PHISTEP_ABI
