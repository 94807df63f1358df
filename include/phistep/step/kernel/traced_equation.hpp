/// @file
/// The equation of a step whose slopes and error a controller or dense output reads. To the same text of a scheme it leaves in
/// the trace (step/transaction/trace.hpp) the slope y'(t) that forward begins with, known from the step before or by a force
/// call, and the slope at the end of each resolve, (next − b)/γ: no evaluation.
#pragma once

#include <optional>
#include <utility>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Eq>
struct TracedEquation : Eq {
  using S = typename Eq::S;
  using Eq::y, Eq::t, Eq::dt, Eq::next, Eq::psi, Eq::kernel, Eq::rhs;
  using typename Eq::Scalar, typename Eq::Plain, typename Eq::Rate;
  static constexpr bool is_traced = true;
  /// Whether falling rates count: errors are judged, and filtered by the matrix of the step's start.
  [[nodiscard]] bool sees_falling_rates() const {
    return Eq::Kernel::may_see_falling_rates && judge.has_sizes() && !kernel.last_solve().is_singular;
  }

  Trace<Plain>& trace;
  const Judge<Plain>& judge;
  bool has_prediction = false;  ///< trace.predicted is where the next resolve starts
  bool has_resolved = false;    ///< trace.end is the slope at the end of a resolve of this step
  Scalar sought{};              ///< [time] how long after t the end of that resolve is

  TracedEquation(Eq&& eq, Trace<Plain>& leaves, const Judge<Plain>& by) : Eq{std::move(eq)}, trace{leaves}, judge{by} {
    trace.dt = dt;
    trace.has_slopes = trace.has_error = false;
    trace.error_scale_square = 1;
  }

  /// trace.start = y'(t): no force call where the step before has left it.
  [[nodiscard]] Outcome start() {
    if (trace.knows_start) return Outcome::success;
    if (!rhs().slope(t, y, trace.start, psi)) {
      copy_blocks<S>(next, y);  // kept for the failure message
      return Outcome::non_finite_force;
    }
    trace.knows_start = true;
    kernel.algebraic_start().start_by_force();
    return Outcome::success;
  }
  [[nodiscard]] Outcome start(const Gamma<Scalar>& gamma) { return check_start(gamma); }
  [[nodiscard]] Outcome forward(const Advance<Scalar>& by) {
    if (const Outcome bad = start(); failed(bad)) return bad;
    assign<S>(next, in<S>(y) + by.kick * in<S>(trace.start));
    return Outcome::success;
  }
  [[nodiscard]] Outcome euler(const auto& by) { return forward(by); }
  /// The kick gives y'(t); the next kick is predicted to be like it.
  [[nodiscard]] Outcome kick_drift(const auto& by) {
    if (const Outcome bad = Eq::kick_drift(by); failed(bad)) return bad;
    assign_solved<S>(trace.start, (in<S>(next) - in<S>(y)) / by.kick);
    position_of<S>(trace.start) = velocity_of<S>(y);
    assign<S>(trace.predicted, in<S>(next) + (in<S>(next) - in<S>(y)));
    has_prediction = true;
    return Outcome::success;
  }
  [[nodiscard]] Outcome slope_at_start(Rate& k) {
    if (const Outcome bad = start(); failed(bad)) return bad;
    for_each_block([](auto, auto& to, const auto& slope) { to = slope; }, Rate::blocks(k),
                   Blocks<S>::solved(trace.start));
    return Outcome::success;
  }
  /// Predicts next on the parabola through y, y' and the slope known last: that of the step before (Adams-Bashforth of order 2 at h = Δt), or
  /// of this step's last resolve.
  void predict(Scalar h) {
    const Scalar since = has_resolved ? sought : -trace.dt_before;  // that slope, seen from t
    sought = h;
    if (trace.dt_before == 0 || trace.has_hidden) return;  // y' may be that of a transient
    const auto start = in<S>(trace.start), known = in<S>(has_resolved ? trace.end : trace.before);
    assign<S>(trace.predicted, in<S>(y) + h * start + (h * h / (2 * since)) * (known - start));
    has_prediction = true;
  }

  [[nodiscard]] Outcome resolve(const Gamma<Scalar>& gamma, Scalar at) { return resolve(gamma, at, y); }
  /// Solves from the prediction where there is one, and then from `guess` if the force doesn't exist there.
  [[nodiscard]] Outcome resolve(const Gamma<Scalar>& gamma, Scalar at, const Plain& guess) {
    if (has_resolved) copy_blocks<S>(trace.error, trace.end);  // kept for the error: Y' of the resolve before
    copy_blocks<S>(trace.end, next);                           // b
    Outcome outcome = Outcome::non_finite_force;
    if (std::exchange(has_prediction, false)) {
      outcome = Eq::resolve_from(gamma, at, trace.predicted, false, allowed());
      if (is_not_finite(outcome)) copy_blocks<S>(next, trace.end);
      trace.has_met_bound = trace.has_met_bound || is_not_finite(outcome);
    }
    if (is_not_finite(outcome))
      outcome = Eq::resolve_from(gamma, at, guess, &guess == &y && this->knows_first_force(), allowed());
    trace.has_met_bound = trace.has_met_bound || is_not_finite(outcome);
    if (failed(outcome)) return outcome;
    assign_solved<S>(trace.end, (in<S>(next) - in<S>(trace.end)) / gamma.force);
    if constexpr (Eq::Rhs::drifts) position_of<S>(trace.end) = velocity_of<S>(next);
    has_resolved = true;
    return outcome;
  }
  [[nodiscard]] Outcome check_start(const Gamma<Scalar>& gamma) {
    return Eq::check_start(gamma, allowed(), [this](const Plain& x) { return size_of(x, y); });
  }
  [[nodiscard]] Outcome linearize() requires(Eq::needs.stages) { return Eq::linearize(allowed()); }
  [[nodiscard]] SolveTolerance<Plain> allowed() const {
    return {&trace.weight, trace.newton_target, trace.rtol, trace.usual, trace.has_unsized};
  }
  /// trace.end = y' at (t + Δt, next), by a force call
  [[nodiscard]] Outcome end() {
    if (!Eq::Rhs::is_finite(next)) return Outcome::non_finite_state;
    const bool finite = rhs().slope(t + dt, next, trace.end, psi);
    this->ends_with_psi = true;
    return finite ? Outcome::success : Outcome::non_finite_force;
  }
  /// Ψ(t + Δt, next) exists: the next step can start there. A call, where the text hasn't asked for it, that the next step spares.
  [[nodiscard]] Outcome reach_end() {
    if constexpr (Eq::Rhs::Traits::is_affine) return Outcome::success;  // it has no bounds
    if (is_mild() && !trace.has_met_bound && !trace.asks_end) return Outcome::success;
    if (!std::exchange(this->ends_with_psi, true)) rhs().evaluate_into(t + dt, next, psi);
    if (!all_finite(Rate::blocks(psi))) {
      trace.has_met_bound = true;
      return Outcome::non_finite_force;
    }
    this->knows_end = Eq::Kernel::carries;
    return Outcome::success;
  }

  /// trace.rate = y' at the end by a force call, where something has begun that had no size: by that shows whether the step has made it
  /// or blown it up. Under a singular M what the algebraic equations lack there is an error, too.
  /// @param reach  calls the force there, at a place of the scheme's own or in psi
  [[nodiscard]] Outcome look_at_end() {
    return look_at_end([this] { return reach_end(); });
  }
  [[nodiscard]] Outcome look_at_end(auto&& reach) {
    if constexpr (!FieldState<S>) {
      const bool begins = trace.has_unsized && has_births();
      if (!begins && !kernel.last_solve().is_singular) return Outcome::success;
      if (const Outcome bad = reach(); failed(bad)) return bad;
      if (begins && trace.has_slopes) trace.rate = &trace.end;
      if constexpr (Eq::needs.solver || Eq::needs.stages) {  // these slopes may be of the scheme's own relations
        if (!std::exchange(this->ends_with_psi, true)) rhs().evaluate_into(t + dt, next, psi);
        if (begins) {
          assign_solved<S>(trace.predicted, in_rate<S>(psi));
          if constexpr (Eq::Rhs::drifts) position_of<S>(trace.predicted) = velocity_of<S>(next);
          static_cast<void>(divide_by_mass(Blocks<S>::solved(trace.predicted), rhs().masses()));
          trace.rate = &trace.predicted;
        }
        return look_at_algebraic_end();
      }
    }
    return Outcome::success;
  }

  /// What has begun in this try has the weight of what it has become.
  void weigh_births() {
    if constexpr (!FieldState<S>)
      for_each_number(
          [rtol = static_cast<Scalar>(trace.rtol)](std::size_t, Scalar& weight, Scalar to) {
            if (weight == 0 && to != 0) weight = 1 / at_least_normal<Scalar>(rtol * std::abs(to));
          },
          Blocks<S>::all(trace.weight), Blocks<S>::all(next));
  }

  // ---- errors that a filter hides where rates fall (falling_rates.hpp) ----

  [[nodiscard]] Outcome filter(Plain& error) {
    if (!Eq::Kernel::may_see_falling_rates || !judge.has_sizes() || is_mild()) return Eq::filter(error);
    if (const Outcome bad = add_defect(this->last_gamma.force, error); failed(bad)) return bad;
    keep_unfiltered(error);
    if (const Outcome bad = filter_once(error); failed(bad)) return bad;
    const Outcome seen = see_hidden(this->last_gamma);
    if (trace.has_hidden) kernel.resolvent().forget();  // its J is that of another rate
    return seen;
  }
  [[nodiscard]] Outcome filter_once(Plain& x) { return Eq::filter(x); }
  /// to.solved += γ (M⁻¹Ψ⁺ − trace.end)
  [[nodiscard]] Outcome add_defect(Scalar gamma, Plain& to) {
    if constexpr (Eq::Kernel::may_see_falling_rates)
      if (sees_falling_rates()) return kernel.falling_rates().add_defect(*this, gamma, to);
    return Outcome::success;
  }
  void keep_unfiltered(const Plain& x) {
    if constexpr (Eq::Kernel::may_see_falling_rates) kernel.falling_rates().keep(x);
  }
  void keep_unfiltered_product(const Plain& x) {
    if constexpr (Eq::Kernel::may_see_falling_rates) kernel.falling_rates().keep_product(x, rhs().masses());
  }
  /// @param allowed  of a scheme that judges its steps itself
  [[nodiscard]] Outcome see_falling_rates(const Gamma<Scalar>& gamma, bool knows_beside,
                                          std::optional<double> allowed = {}) {
    if constexpr (Eq::Kernel::may_see_falling_rates)
      if (sees_falling_rates())
        return kernel.falling_rates().see(*this, gamma, allowed.value_or(judge.allowed()), knows_beside);
    return Outcome::success;
  }
  /// The same after an iteration, whose J may be old. trace.has_hidden: rates have fallen since it was made
  [[nodiscard]] Outcome see_hidden(const Gamma<Scalar>& gamma, std::optional<double> allowed = {}) {
    const double before = size_of(trace.error, next);
    const Outcome seen = see_falling_rates(gamma, false, allowed);
    trace.has_hidden = size_of(trace.error, next) > 2 * before;
    return seen;
  }
  /// ‖x‖ in units of the tolerance, of what a state between y and y1 is off
  [[nodiscard]] double size_of(const Plain& x, const Plain& y1) const { return judge.size(x, y, y1, trace); }
  /// No less than that of what next is off, for less work
  [[nodiscard]] double size_at_most(const Plain& x) const { return judge.size_at_most(x, y, next, trace); }
  /// The size of the step's own estimate, trace.error, likewise, for schemes that judge their steps themselves
  [[nodiscard]] double size_of_error() const { return judge.size_of_error(y, next, trace); }
  /// Completes trace.start where it is M⁻¹Ψ of a singular M.
  void complete_start() { kernel.algebraic_start().complete_start(rhs(), *this); }
  void tell(auto&& f) { f(trace); }
  void leave_force() requires Eq::Kernel::carries { this->knows_end = this->ends_with_psi; }

 private:
  [[nodiscard]] bool has_births() const {
    bool any = false;
    for_each_number([&any](std::size_t, Scalar weight, Scalar to) { any = any || (weight == 0 && to != 0); },
                    Blocks<S>::all(trace.weight), Blocks<S>::all(next));
    return any;
  }
  /// What algebraic equations give has no rate. It counts as blown up if they don't hold to half of it.
  [[nodiscard]] Outcome look_at_algebraic_end() {
    const auto respond = [this](const auto& residual, Plain& x) {
      return Eq::respond(this->last_gamma, t + dt, next, residual, x, allowed());
    };
    return kernel.algebraic_start().look_at_end(rhs(), psi, respond, [this](const Plain& x) {
      const Scalar by = trace.rate == nullptr ? Scalar{0} : 2 * most_power / dt;
      for_each_number(
          [by](std::size_t, Scalar lacks, Scalar& rate, Scalar& error) {
            rate += by * lacks;
            if (std::abs(lacks) > std::abs(error)) error = lacks;
          },
          Blocks<S>::solved(x), Blocks<S>::solved(trace.predicted), Blocks<S>::solved(trace.error));
    });
  }
  [[nodiscard]] static bool is_not_finite(Outcome outcome) {
    return outcome == Outcome::non_finite_force || outcome == Outcome::non_finite_state;
  }
  /// The last resolve's matrix is that of the masses, nearly. Of fields over ranks more is not asked: it would take them reductions.
  [[nodiscard]] bool is_mild() const {
    if constexpr (FieldState<S>) return true;
    else if constexpr (Eq::needs.stages) return false;
    else return has_resolved && kernel.resolvent().is_mild();
  }
};

}}  // namespace phistep::PHISTEP_ABI
