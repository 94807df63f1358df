/// @file
/// Terms of a force that enter as kicks around the step of the others, Ψ = Ψ_f + Ψ_e (force/at.hpp).
///
/// Terms at φ = 0 in an implicit scene: Strang's splitting (SIAM J. Numer. Anal. 5 (1968) 506; with φ = ½ inside it is IMEX of
/// Zhang & Schlick, J. Comput. Chem. 14 (1993) 1212, and Stern & Grinspun, MMS 7 (2009) 1779),
///
///     v½ = v + ½Δt M⁻¹Ψ_e(t, r),   the scheme's step for Ψ_f from (r, v½) to (r⁺, v'),                           (1)
///     v⁺ = v' + ½Δt M⁻¹Ψ_e(t+Δt, r⁺)                                                                             (2)
///
/// of order 2 where the inner scheme is, and with φ = ½ stable for Δt ω_e < 2 whatever Ψ_f. Ψ_e in (2) is the next step's
/// in (1), so that a step calls Ψ_e once; a constant Ψ_e is called once for all. Where Ψ_e depends on what it moves (on v;
/// on y of a first-order state), each half is one explicit midpoint step with t held, two calls:
///
///     k = y + ¼Δt M⁻¹Ψ_e(t, y),   y½ = y + ½Δt M⁻¹Ψ_e(t, k)                                                      (3)
///
/// Take φ = ½ inside. A scheme that damps stiff modes (φ > ½, TR-BDF2) takes away, step by step, what the kicks put into
/// them: in the stiff limit it is then of order 1, and a stiff pendulum under gravity loses its swing.
///
/// Slow terms called once in k inner steps: r-RESPA (M. Tuckerman, B. J. Berne & G. J. Martyna, J. Chem. Phys. 97 (1992) 1990,
/// eq. 2.22; E. Hairer, C. Lubich & G. Wanner, Geometric Numerical Integration, VIII.4, the impulse method), of each the same with
/// (1−φ)Δt and φΔt, and k steps of h = Δt/k in between: φ = ½ around velocity Verlet, 0 around symplectic_euler, 1 around its
/// adjoint. Where Ψ_f has slow terms of its own, each h is such a step again: so all levels are one loop over inner steps, in
/// which term j gets (1) at the beginning of each k_j and (2) at their end. Between two such ends velocity Verlet knows Ψ_j from
/// the one: n outer steps call term j n K/k_j times, K the largest k, and once more at their start; Euler's schemes n K/k_j times.
///
/// Each part of that step is the exact flow of a part of the energy: symplectic, and with φ = ½ symmetric in time, of order 2.
/// It resonates where an outer step is half a period of a fast mode, ωΔt = π, and at multiples of that: a slow force then drives
/// the fast mode, however weak it is and however small h (preflight says up to which Δt none does).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/phi.hpp"
#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/force/at.hpp"
#include "phistep/schemes/velocity_verlet.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/kernel/scheme_on.hpp"
#include "phistep/step/transaction/edit_guard.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// φ of slow terms in halves; −1: this scheme takes none.
template <class Scheme>
inline constexpr int slow_halves = std::is_same_v<Scheme, VelocityVerlet>                             ? 1
                                   : std::is_same_v<const Scheme, decltype(symplectic_euler)>         ? 0
                                   : std::is_same_v<const Scheme, decltype(symplectic_euler_adjoint)> ? 2
                                                                                                      : -1;

/// The kicks (1) and (2) around a scheme's step for the other terms, or around several steps of h. @tparam halves  2φ of the kicks
template <class Inner, State S, class Rhs, int halves = 1>
class KickScheme : public SchemeDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Traits = typename Rhs::KickTraits;
  static constexpr bool has_inner_steps = Rhs::has_inner_steps;
  static_assert(Refusal<Traits::fault, Rhs::drifts>::is_said);
  static_assert(
      !has_inner_steps || !Traits::valid || !Traits::uses_velocity,
      "phistep: a term of seldom(k, term) must ignore v: f(r), or a struct with uses_velocity = false; drag and "
      "friction belong to the fast terms");
  static_assert(!has_inner_steps || Rhs::blocks == 1,
                "phistep: seldom(k, term) needs a motion (r, v) and no other unknowns");
  static_assert(
      !has_inner_steps || !Rhs::slow_terms_have_history,
      "phistep: a term of seldom(k, term) may remember nothing but a neighbour list: friction springs belong to the "
      "fast terms");

  /// Ψ_e depends on what the kicks move.
  static constexpr bool couples = !Rhs::drifts || Traits::uses_velocity || Rhs::blocks > 1;
  static constexpr bool reuses = has_inner_steps ? halves == 1 : !couples && !Rhs::has_history;
  static constexpr bool is_constant =
      !has_inner_steps && reuses && !Traits::uses_time && Traits::structure == Structure::none;

  /// The inner scheme may carry Ψ_f over the kicks where that ignores what they move.
  template <class R>
  static constexpr KernelNeeds needs = [] {
    KernelNeeds inner = Inner::template needs<R>;
    inner.carries = inner.carries && !R::couples_unknowns;
    inner.passes = 0;
    return inner;
  }();

  KickScheme(const auto& scheme, const Plain& y) : inner_{scheme, y} { allocate(y); }
  void resize(const Plain& y) {
    inner_.resize(y);
    allocate(y);
  }
  [[nodiscard]] int order() const { return std::min(2, inner_.order()); }
  /// Evaluations of slow term j, in the order of the sum.
  [[nodiscard]] std::int64_t calls(std::size_t j) const { return levels_[j].calls; }

  using Progress = typename Inner::Progress;
  [[nodiscard]] Progress progress() const { return inner_.progress(); }
  void resume(Progress progress) { inner_.resume(progress); }
  void archive(auto& ar) { ar("inner", inner_, "known_at", guard_, "levels", levels_); }
  void reset() { inner_.reset(); }
  void accepted() { inner_.accepted(); }
  void forget() {
    inner_.forget();
    guard_.forget();
    for (Level& level : levels_) level.known = false;
  }

  [[nodiscard]] static bool leaves_force() { return false; }  // the last inner step has

  [[nodiscard]] Outcome step(auto& eq) {
    Rhs& rhs = eq.rhs();
    int steps = 1;
    if constexpr (has_inner_steps) steps = inner_steps(rhs.whole_force());
    const Scalar h = eq.dt / static_cast<Scalar>(steps);
    if (has_inner_steps && eq.t + h == eq.t) return Outcome::step_too_small;
    const auto time = [&](int i) { return i == steps ? eq.t + eq.dt : eq.t + static_cast<Scalar>(i) * h; };
    // From now to next and back: the last inner step ends in eq.next.
    Plain *now = steps % 2 == 0 ? &eq.next : &other_, *next = steps % 2 == 0 ? &other_ : &eq.next;
    copy_blocks<S>(*now, eq.y);
    // What a failed step leaves is Ψ_e at the place that the guard names, and so may stay.
    const bool holds = reuses && guard_.holds(rhs.inside(eq.t), eq.y);
    if constexpr (!is_constant)
      for (Level& level : levels_) level.known = holds;
    for (int i = 0; i < steps; ++i, std::swap(now, next)) {
      if constexpr (has_inner_steps) begin_histories(rhs, i, h, time(i), *now);
      if (const Outcome bad = begin_kicks(rhs, i, h, time(i), *now); failed(bad)) return end(eq, *now, bad);  // (1)
      auto inside = eq.part(*now, time(i), h, *next);
      if (const Outcome bad = take_step(inner_, inside); failed(bad)) return end(eq, *next, bad);
      eq.ends_as(inside);
      if constexpr (has_inner_steps) rhs.commit_rest(time(i + 1), *next);
      if (const Outcome bad = end_kicks(rhs, i + 1, h, time(i + 1), *next); failed(bad))
        return end(eq, *next, bad);  // (2)
    }
    if constexpr (reuses && !is_constant) guard_.remember(rhs.inside(eq.t + eq.dt), eq.next);
    return Outcome::success;
  }

 private:
  /// Ψ of one slow term, or of all kicks.
  struct Level {
    RateOf<S> psi;
    bool known = false;  ///< at the place where the step stands
    std::int64_t calls = 0;

    void archive(auto& ar) {
      ar("calls", calls, "known", known);
      ar.check(can_be_count(calls));
      ar.in_place("value", psi);
    }
  };
  /// All kicks as one term, which the right-hand side evaluates.
  struct AllKicks {
    [[nodiscard]] static constexpr int k() { return 1; }
  };

  /// All that begin here, before any Ψ: a failure message may ask every term.
  void begin_histories(Rhs& rhs, int i, Scalar h, Scalar t, const Plain& y) {
    rhs.begin_rest(t, h, y);
    static_cast<void>(for_each_due(rhs, i, [&](Level&, auto& term, auto& memory) {
      begin_force(unwrap(term), t, static_cast<Scalar>(term.k()) * h, rhs.view(y), memory);
      return Outcome::success;
    }));
  }
  /// (1), of the terms due at inner step i
  [[nodiscard]] Outcome begin_kicks(Rhs& rhs, int i, Scalar h, Scalar t, Plain& y) {
    if constexpr (halves == 2) return Outcome::success;
    return for_each_due(rhs, i, [&](Level& level, auto& term, auto& memory) {
      const Outcome outcome =
          kick(rhs, level, term, memory, t, y, (2 - halves) * static_cast<Scalar>(term.k()) * h / 2);
      level.known = level.known && is_constant;
      return outcome;
    });
  }
  /// (2), of the terms due at the end of inner step i−1
  [[nodiscard]] Outcome end_kicks(Rhs& rhs, int i, Scalar h, Scalar t, Plain& y) {
    return for_each_due(rhs, i, [&](Level& level, auto& term, auto& memory) {
      Outcome outcome = Outcome::success;
      if constexpr (halves != 0)
        outcome = kick(rhs, level, term, memory, t, y, halves * static_cast<Scalar>(term.k()) * h / 2);
      if constexpr (halves == 2) level.known = false;
      if constexpr (has_inner_steps)
        if (!failed(outcome)) commit_force(unwrap(term), t, rhs.view(y), memory);
      return outcome;
    });
  }
  /// y.solved += γ M⁻¹Ψ_j(t, y), or the explicit midpoint rule for it
  [[nodiscard]] Outcome kick(Rhs& rhs, Level& level, auto& term, const auto& memory, Scalar t, Plain& y, Scalar gamma) {
    if (!level.known) {
      guard_.forget();  // an exception leaves Ψ half written
      if (!evaluate(rhs, level, term, memory, t, y)) return Outcome::non_finite_force;
      level.known = !couples;
    }
    if constexpr (couples) {
      copy_blocks<S>(middle_, y);
      static_cast<void>(
          kick_blocks<S>(middle_, gamma / 2, RateOf<S>::blocks(std::as_const(level.psi)), scratch_, rhs.masses()));
      if (!evaluate(rhs, level, term, memory, t, middle_)) return Outcome::non_finite_force;  // (3)
    }
    return kick_blocks<S>(y, gamma, RateOf<S>::blocks(std::as_const(level.psi)), scratch_, rhs.masses())
               ? Outcome::success
               : Outcome::non_finite_state;
  }
  /// Whether Ψ_j is finite, before it spoils what it is added to: so the message finds the term.
  [[nodiscard]] bool evaluate(Rhs& rhs, Level& level, auto& term, [[maybe_unused]] const auto& memory, Scalar t,
                              const Plain& y) {
    if constexpr (has_inner_steps) {
      ++level.calls;
      ++rhs.statistics().kick_calls;
      assign_force(unwrap(term), rhs.inside(t), rhs.view(y), memory, level.psi);
    } else {
      rhs.evaluate_kicks(t, y, level.psi);
    }
    return all_finite(RateOf<S>::blocks(level.psi));
  }
  /// f(level, term, its memory) → Outcome for those with k | i, to the first that fails
  [[nodiscard]] Outcome for_each_due([[maybe_unused]] Rhs& rhs, [[maybe_unused]] int i, auto&& f) {
    if constexpr (!has_inner_steps) {
      AllKicks all;
      return f(levels_[0], all, all);
    } else {
      Outcome outcome = Outcome::success;
      rhs.for_each_seldom([&](std::size_t j, auto& term, auto& memory) {
        if (!failed(outcome) && i % term.k() == 0) outcome = f(levels_[j], term, memory);
      });
      return outcome;
    }
  }
  /// The step ends early: next and psi tell the failure message where.
  [[nodiscard, gnu::always_inline]] inline Outcome end(auto& eq, const Plain& where, Outcome bad) {
    if (&where != &eq.next) copy_blocks<S>(eq.next, where);
    for (const Level& level : levels_)
      if (first_non_finite(RateOf<S>::blocks(level.psi))) eq.psi = level.psi;
    return bad;
  }
  void allocate(const Plain& y) {
    other_ = y;
    if constexpr (couples) middle_ = y;
    for (Level& level : levels_) level.psi = make_rate<S>(y), level.known = false;
    // A fixed-size state is copied whole, and so filled whole.
    if constexpr (Rhs::has_matrix_mass || static_unknowns<S> != Eigen::Dynamic) scratch_ = make_rate<S>(y);
    guard_.forget();
  }

  Inner inner_;
  Plain other_;
  [[no_unique_address]] Only<couples, Plain> middle_;
  std::array<Level, has_inner_steps ? Parts<typename Rhs::Whole>::template places<true>.size() : 1> levels_;
  RateOf<S> scratch_;  // only matrix masses write it
  EditGuard<S, true, Traits::uses_time> guard_;
};

/// The text of a scheme under a force: with kicks around it where terms of the force are marked.
template <class Scheme, State S, class Rhs, bool split>
[[nodiscard]] constexpr auto text_at_work() {
  using Alone = SchemeOn<Scheme, S>;
  if constexpr (Rhs::has_inner_steps && slow_halves<Scheme> >= 0)
    return std::type_identity<KickScheme<Alone, S, Rhs, slow_halves<Scheme>>>{};
  else if constexpr (split) return std::type_identity<KickScheme<Alone, S, Rhs>>{};
  else return std::type_identity<Alone>{};
}
template <class Scheme, State S, class Rhs, bool split>
using TextAtWork = typename decltype(text_at_work<Scheme, S, Rhs, split>())::type;

/// Whether a stepper of that scheme takes the marks of a force as they are.
template <class F, class Scheme, State S>
struct KicksRefusal : Refuses {
  static_assert(SeldomRefusal<Unwrapped<F>>::is_said);
  static_assert(
      !has_seldom<Unwrapped<F>> || slow_halves<Scheme> >= 0,
      "phistep: seldom(k, term) makes inner steps of velocity_verlet, symplectic_euler or symplectic_euler_adjoint: an "
      "implicit scheme, and one of a higher order, takes the sum without it");
  static_assert(
      !is_split<Unwrapped<F>, Scheme> || !SchemeOn<Scheme, S>::looks_back,
      "phistep: generalized_alpha, newmark, hht and bossak carry an acceleration from step to step, which the kicks of "
      "at(forward_euler, term) would make wrong: leave out at(...), or take trapezoidal");
  static_assert(!is_at<F>, "phistep: at(scheme, term) marks a term of a sum, there is no sum here");
};

}}  // namespace phistep::PHISTEP_ABI
