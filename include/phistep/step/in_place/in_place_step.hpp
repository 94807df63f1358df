/// @file
/// Explicit steps of states in place, without a copy of state or force: Euler's in one pass over the arrays, velocity
/// Verlet's in two. A pass reads each number once and writes it where it was,
///
///     kept ← r, v, f   →   v⁺ = v + (h/m) f,   r⁺ = r + (before v + after v⁺)   →   r, v,
///
/// and what it keeps puts the arrays back if the step fails.
#pragma once

#include <cstdint>
#include <tuple>
#include <type_traits>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/force/routine.hpp"
#include "phistep/step/equation/gamma.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/in_place/pass_in_place.hpp"
#include "phistep/step/transaction/edit_guard.hpp"
#include "phistep/step/transaction/transaction.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Whether Force is a routine that works on the arrays of S.
template <class S, class Force>
inline constexpr bool is_routine_of = false;
template <class S, class Routine, bool reads_velocities>
inline constexpr bool is_routine_of<S, RoutineForce<S, Routine, reads_velocities>> = true;

/// The equation for schemes of one or two passes, and the transaction around their steps.
template <State S, class RightHandSideOf, int passes>
class InPlaceStep {
 public:
  using Rhs = RightHandSideOf;
  using Scalar = ScalarOf<S>;
  static constexpr bool carries = passes == 2;
  struct Equation {
    InPlaceStep& kernel;
    S& state;
    const Scalar t;   ///< [time]
    const Scalar dt;  ///< [time]
    const Origin origin;

    /// The state is y + γ M⁻¹Ψ(t, y), r drifted.
    [[nodiscard]] Outcome euler(const auto& by) { return kernel.kick_drift(*this, by); }
    [[nodiscard]] Outcome kick_drift(const auto& by) { return kernel.kick_drift(*this, by); }
    /// The state's v is v + γ M⁻¹Ψ(t, r): the step's last pass.
    [[nodiscard]] Outcome resolve(const Gamma<Scalar>& gamma, Scalar at) { return kernel.kick(*this, gamma.force, at); }
  };

  explicit InPlaceStep(const S& state) { log_.begin(state); }
  /// The force's arrays are those of the state.
  [[nodiscard]] static bool can(Rhs& rhs, const S& state) { return rhs.force().arrays() == &state; }
  /// Forgets where the next step starts.
  void forget() {
    known_ = Known::nothing;
    log_.forget();
  }

  template <class Advance, class Transaction>
  StepReport run(Rhs& rhs, Transaction& transaction, S& state, Scalar t, Scalar dt, Origin origin, Advance&& advance) {
    if (const Outcome bad = transaction.open(t, dt); failed(bad)) return transaction.refuse(rhs, bad, t, dt);
    rhs_ = &rhs;
    state.note_length();
    if (!log_.begin(state)) known_ = Known::nothing;
    rhs.bound_times(t, dt, origin);
    Equation equation{*this, state, t, dt, origin};
    const auto undo = [&] {
      known_ = Known::nothing;
      if (state.has_kept_length()) log_.put_back(state);
      else log_.forget();
    };
    Outcome outcome;
    try {
      outcome = advance(equation);
    } catch (...) {
      undo();
      throw;
    }
    if (failed(outcome)) {
      transaction.show_end(state, state.rate());
      undo();
      return transaction.report_shown(rhs, outcome, t, dt, state);
    }
    log_.accept();
    ++rhs.statistics().steps;
    return {Outcome::success, 0, nullptr};
  }

 private:
  enum class Known : std::uint8_t { nothing, unchecked, checked };

  [[nodiscard]] Outcome kick_drift(Equation& step, const auto& by) {
    const bool looks = carries && step.origin != Origin::unedited;
    bool known = known_ != Known::nothing && (!looks || known_ == Known::checked) &&
                 same_time<Rhs::Traits::uses_time>(rhs_->inside(step.t), t_);
    known_ = Known::nothing;
    bool finite = true;
    if (known) {
      const std::uint64_t left = seen_;
      finite = pass<true, !carries>(step, by, looks, log_.psi());
      if (looks && found_ != left) {  // edited since
        log_.put_back_state(step.state);
        log_.forget();
        known = false;
      }
    }
    if (!known) {
      evaluate(step.state, step.t);
      finite = pass<true, !carries>(step, by, looks, nullptr);
    }
    return finite ? Outcome::success : Outcome::non_finite_state;
  }
  [[nodiscard]] Outcome kick(Equation& step, Scalar gamma, Scalar t) {
    evaluate(step.state, t);
    if (!pass<false, true>(step, Advance{gamma, Zero{}, Zero{}}, false, nullptr)) return Outcome::non_finite_state;
    known_ = step.origin == Origin::unedited ? Known::unchecked : Known::checked;
    t_ = rhs_->inside(t);
    return Outcome::success;
  }
  /// The arrays' forces are Ψ of what else they hold.
  void evaluate(S& state, Scalar t) {
    log_.keep_rate(state);
    if (rhs_->force().looks_next()) log_.keep_state(state);
    ++rhs_->statistics().force_calls;
    rhs_->force().call(rhs_->inside(t));
  }
  template <bool keeps_state, bool keeps_psi>
  [[nodiscard]] bool pass(Equation& step, const auto& by, bool looks, const Scalar* psi) {
    const auto& mass = std::get<0>(rhs_->masses());
    PassInPlace<S, std::remove_cvref_t<decltype(mass.scaled(by.kick))>, std::remove_cvref_t<decltype(by)>> pass{
        step.state, mass.scaled(by.kick), by, psi};
    const bool finite = pass.template run<keeps_state, keeps_psi>(log_, looks);
    if constexpr (keeps_state) found_ = pass.found(), seen_ = pass.left();
    return finite;
  }

  Rhs* rhs_ = nullptr;  // during a step
  UndoLog<S> log_;
  Known known_ = Known::nothing;        // whether the log has Ψ of what the last step left …
  Scalar t_{};                          // [time] … at this time
  std::uint64_t seen_ = 0, found_ = 0;  // the positions that the last step left, that the last pass found
};

}}  // namespace phistep::PHISTEP_ABI
