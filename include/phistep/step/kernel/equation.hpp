/// @file
/// The equation as a scheme sees it during one step, bound to where that starts and made anew for each:
///
///     forward   next = y + γ M⁻¹Ψ(t, y), and for motion r drifted             evaluate
///     resolve   next = b on entry; M (next − b) = γ Ψ(t, next)                the implicit solve
///     filter    e ← (1 − γM⁻¹C − γ²M⁻¹K)⁻¹ e, with the last resolve's matrix
///
/// or, in place of resolves, linear stages (linear_stages.hpp):
///
///     linearize   Ψ, J (and Ψ_t) at (t, y)
///     factorize   M − γJ
///     solve       (M − γJ) x = b
///
/// Each is counted, each guarded. What only a controller or dense output reads is left by a traced equation
/// (traced_equation.hpp), to the same text.
#pragma once

#include <utility>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/solve/increment.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @tparam KernelOf  what outlives the step: force and masses, a way to solve, the history
template <class KernelOf>
struct Equation {
  using Kernel = KernelOf;
  using S = typename Kernel::StateType;
  using Rhs = typename Kernel::Rhs;
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  static constexpr auto needs = Kernel::needs;
  static constexpr bool is_traced = false, has_time = !Rhs::is_autonomous;

  Kernel& kernel;
  const Plain& y;   ///< the state at t
  const Scalar t;   ///< [time]
  const Scalar dt;  ///< [time]
  Plain& next;      ///< becomes the state at t + Δt
  Rate& psi;        ///< Ψ(t, y) where `knows_start`, else scratch
  const typename Rhs::Masses& masses;
  bool knows_start;
  bool is_carried = knows_start;  ///< it comes from the step before, as a solve there has left it
  bool ends_with_psi = false;     ///< psi is Ψ(t', next) of the last resolve
  bool knows_end = false;         ///< psi is Ψ(t + Δt, next), for the next step
  bool is_state_next = false;     ///< the state is what next would be, nothing is left to commit
  Gamma<Scalar> last_gamma{};     ///< of the last resolve

  // ---- evaluate ----

  /// next = y + γ M⁻¹Ψ(t, y), next.r = r + before v + after v⁺
  [[nodiscard]] Outcome forward(const Advance<Scalar>& by) {
    if constexpr (resolves_check_state())  // fields under fixed_point(): nothing is checked here
      if (by.kick != 0) {
        know_start();
        advance_fields<S>(next, y, by, Rate::blocks(std::as_const(psi)), rhs().masses());
        return Outcome::success;
      }
    if (by.kick != 0) return kick_drift(by);
    copy_blocks<S>(next, y);  // no weight on Ψ(t, y): it isn't evaluated
    drift_blocks<S>(next, by.before);
    // What follows neither moves these positions nor checks them.
    return by.before == 0 || Rhs::is_finite(next) ? Outcome::success : Outcome::non_finite_state;
  }
  /// All of an explicit step, in one pass; γ ≠ 0
  [[nodiscard, gnu::always_inline]] inline Outcome euler(const auto& by) { return kick_drift(by); }
  /// next = y + γ M⁻¹Ψ(t, y) with the drift, in one pass; γ ≠ 0: what an implicit step has before its resolve (forward), or the first
  /// part of an explicit one, which a kick with the same γ follows.
  [[nodiscard, gnu::always_inline]] inline Outcome kick_drift(const auto& by) {
    return kernel.passes().kick_drift(rhs(), *this, by);
  }
  /// next = next + γ M⁻¹Ψ(t, next), where Ψ ignores what it moves
  [[nodiscard, gnu::always_inline]] inline Outcome kick(Scalar gamma, Scalar at) {
    ends_with_psi = true;
    return kernel.passes().kick(rhs(), *this, gamma, at);
  }
  /// psi = Ψ(at, Y); what is not finite in it shows in the step.
  [[gnu::always_inline]] inline void evaluate(Scalar at, const Plain& Y) {
    knows_start = false;
    rhs().evaluate_into(at, Y, psi);
  }
  /// k = M⁻¹Ψ(t, y)
  [[nodiscard]] Outcome slope_at_start(Rate& k) {
    if constexpr (Kernel::carries) {
      know_start();
      k = psi;
    } else {
      rhs().evaluate_into(t, y, k);
    }
    if (divide_by_mass(Rate::blocks(k), rhs().masses())) return Outcome::success;
    psi = k;
    return Outcome::non_finite_force;
  }

  // ---- resolve ----

  /// next = b on entry, the solution of M (next − b) = γ Ψ(at, next) on exit; sought from y
  [[nodiscard, gnu::always_inline]] inline Outcome resolve(const Gamma<Scalar>& gamma, Scalar at) {
    return resolve_from(gamma, at, y, knows_first_force(), {});
  }
  /// The same, sought from a guess, which must not be `next`.
  [[nodiscard]] Outcome resolve(const Gamma<Scalar>& gamma, Scalar at, const Plain& guess) {
    return resolve_from(gamma, at, guess, false, {});
  }
  /// Where M is singular, refuses a start that does not satisfy the algebraic equations (algebraic_start.hpp): once, with W for
  /// the step's first γ.
  [[nodiscard]] Outcome check_start(const Gamma<Scalar>& gamma) {
    return check_start(gamma, SolveTolerance<Plain>{}, nullptr);
  }
  /// Takes out of an error estimate what the scheme damps anyway (L. F. Shampine, ACM Trans. Math. Softw. 10 (1984) 291):
  /// without it, stiff components that are long at rest would rule Δt. Solved blocks only: r is not stiff.
  [[nodiscard]] Outcome filter(Plain& error) {
    if constexpr (needs.solver) return kernel.resolvent().filter(rhs(), error);
    else return Outcome::success;
  }
  /// k = (next − b)/γ of the last resolve, M⁻¹Ψ where it ended: no evaluation
  void slope_at_end(Rate& k) const {
    const auto& w = kernel.resolvent().increment();
    for_each_part([&](Index at, auto& block) { flat(block) = phistep::part(w, at, block) / last_gamma.force; },
                  Rate::blocks(k));
  }
  /// next.solved += factor·(next − b) of the last resolve
  void add_increment(Scalar factor) { add_unknowns<S>(next, factor, kernel.resolvent().increment()); }

  // ---- linear stages ----

  /// psi = Ψ(t, y), with J and, where has_time, Ψ_t there
  [[nodiscard]] Outcome linearize() requires(needs.stages) { return linearize(SolveTolerance<Plain>{}); }
  [[nodiscard]] const auto& psi_t() const requires(needs.stages&& has_time) { return kernel.resolvent().psi_t(); }
  /// M − γJ of the last linearization, factorized
  [[nodiscard]] Outcome factorize(Scalar gamma) requires(needs.stages) {
    return kernel.resolvent().factorize(rhs(), gamma);
  }
  /// (M − γJ) x = b, in place, for all blocks
  [[nodiscard, gnu::always_inline]] inline Outcome solve(Scalar gamma, Plain& x) requires(needs.stages) {
    return kernel.resolvent().solve(rhs(), gamma, x);
  }
  /// to.solved += factor M x
  void add_mass_product(Plain& to, Scalar factor, const Plain& x) const {
    for_each_block(
        [factor](auto, auto& out, const auto& of, const auto& mass) {
          if constexpr (FieldState<S>) out += (factor * static_cast<Scalar>(mass[0])) * of;
          else mass.add_product([&](Index i) { return factor * of.data()[i]; }, out);
        },
        Blocks<S>::solved(to), Blocks<S>::solved(x), rhs().masses());
  }
  /// The linear stages themselves, for schemes that want more of them, and how well they have to be solved.
  [[nodiscard]] auto& stages() requires(needs.stages) { return kernel.resolvent(); }
  [[nodiscard]] SolveTolerance<Plain> allowed() const { return {}; }

  // ---- what only a traced step handles ----

  /// Notes x = M e₀, or e₀, to which the next filter is applied.
  static void keep_unfiltered_product(const Plain& /*x*/) {}
  static void keep_unfiltered(const Plain& /*x*/) {}
  /// The error is W₀⁻¹ M e₀, γ that of W₀, and where rates fall grows by what that has hidden. The flag says that psi is
  /// Ψ(t + Δt, next − error).
  [[nodiscard]] static Outcome see_falling_rates(const Gamma<Scalar>& /*gamma*/, bool /*knows_beside*/) {
    return Outcome::success;
  }

  /// Whether a component that had no size has begun as a power of Δt.
  [[nodiscard]] static Outcome look_at_end(auto&&...) { return Outcome::success; }

  // Nothing in a plain step. In a traced one:

  /// Makes the slope at the start known, and checks that it is consistent with γ.
  [[nodiscard]] static Outcome start(const Gamma<Scalar>&) { return Outcome::success; }
  /// The next resolve may start from where the slopes known lead by t + h.
  static void predict(Scalar /*h*/) {}
  /// Calls f(trace), but in a traced step only.
  static void tell(auto&& /*f*/) {}

  // ---- parts, ends ----

  [[nodiscard]] Rhs& rhs() const { return kernel.rhs(); }
  /// A part of this step, from `from` to `to`; `ends_as` follows it.
  [[nodiscard]] Equation part(const Plain& from, Scalar t0, Scalar length, Plain& to) {
    return {kernel, from, t0, length, to, psi, masses, knows_start};
  }
  /// Where this step stands, or ends, is where that part ended.
  void ends_as(const Equation& part) { knows_start = knows_end = part.knows_end; }
  /// psi is Ψ at the step's end.
  void end_with_psi() { ends_with_psi = true; }
  /// Leaves Ψ(t + Δt, next) to the next step, as the last resolve knows it: no evaluation.
  void leave_force() requires Kernel::carries {
    if constexpr (needs.solver)
      if (!ends_with_psi) recover_force<S>(rhs(), kernel.resolvent().increment(), last_gamma.force, psi);
    knows_end = true;
  }

 protected:
  [[nodiscard]] static constexpr bool resolves_check_state() {
    if constexpr (needs.stages) return false;
    else return Kernel::Resolvent::checks_state;
  }
  /// Whether psi is the first Ψ of an iteration that starts from y. That of a motion doesn't: it has y's v, but r = b.r + γ_d v.
  [[nodiscard]] bool knows_first_force() const { return knows_start && Rhs::is_autonomous && !Rhs::drifts; }
  void know_start() {
    if (!knows_start) rhs().evaluate_into(t, y, psi);
    knows_start = true;
  }
  [[nodiscard]] Outcome linearize(const SolveTolerance<Plain>& allowed) {
    const Outcome outcome = kernel.resolvent().linearize(rhs(), t, dt, y, psi, knows_start, allowed);
    knows_start = outcome == Outcome::success;
    if (outcome == Outcome::non_finite_force) copy_blocks<S>(next, y);  // kept for the failure message
    return outcome;
  }
  /// @param size  (x) → ‖x‖ in units of the tolerance, or null
  [[nodiscard]] Outcome check_start(const Gamma<Scalar>& gamma, const SolveTolerance<Plain>& allowed, auto&& size) {
    if constexpr (Rhs::may_be_singular) {
      last_gamma = gamma;
      if (!kernel.algebraic_start().is_due(t, dt, y)) return Outcome::success;
      if constexpr (!needs.stages || needs.shifted) know_start();
      copy_blocks<S>(next, y);  // kept for the failure message
      const Outcome outcome = kernel.algebraic_start().check(
          rhs(), *this, allowed.weight, size,
          [&](const auto& residual, Plain& response) { return respond(gamma, t, y, residual, response, allowed); });
      if (outcome == Outcome::inconsistent_start)
        kernel.transaction().set_inconsistent(kernel.algebraic_start().worst());
      return outcome;
    }
    return Outcome::success;
  }
  /// response = W⁻¹ γ residual, with the step's W or, where there is none, that at (at, x), where psi is Ψ
  [[nodiscard]] Outcome respond(const Gamma<Scalar>& gamma, Scalar at, const Plain& x, const auto& residual,
                                Plain& response, const SolveTolerance<Plain>& allowed) {
    set_zero(Blocks<S>::all(response));
    if constexpr (needs.stages) {
      assign_solved<S>(response, gamma.force * in_rate<S>(residual));
      return kernel.resolvent().solve(rhs(), gamma.force, response);
    } else {
      return kernel.resolvent().respond(rhs(), gamma, at, x, psi, residual, response, allowed);
    }
  }
  [[nodiscard, gnu::always_inline]] inline Outcome resolve_from(const Gamma<Scalar>& gamma, Scalar at,
                                                                const Plain& guess, bool knows_psi,
                                                                const SolveTolerance<Plain>& allowed) {
    if constexpr (!Rhs::couples_unknowns)
      if (gamma.drift == 0) return kick(gamma.force, at);
    if constexpr (needs.solver) {
      auto& resolvent = kernel.resolvent();
      knows_psi = knows_psi && !(is_carried && resolvent.wants_differences());
      knows_start = ends_with_psi = false;
      last_gamma = gamma;
      const Outcome outcome =
          resolvent.resolve(rhs(), gamma, at, next, guess, psi, kernel.transaction().record(), knows_psi, allowed);
      if (failed(outcome) || resolves_check_state()) return outcome;
      return Rhs::is_finite(next) ? Outcome::success : Outcome::non_finite_state;
    }
    return Outcome::success;
  }
};

}}  // namespace phistep::PHISTEP_ABI
