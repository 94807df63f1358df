/// @file
/// Slow terms called once in several inner steps: r-RESPA (M. Tuckerman, B. J. Berne & G. J. Martyna, J. Chem. Phys. 97 (1992)
/// 1990, eq. 2.22; E. Hairer, C. Lubich & G. Wanner, Geometric Numerical Integration, VIII.4, the impulse method). With Ψ = Ψ_f
/// + Ψ_s, Ψ_s = Ψ_s(t, r) called once in k inner steps,
///
///     v ← v + (1−φ)Δt M⁻¹Ψ_s(t, r)                                                                              (1)
///     k steps of the scheme for Ψ_f, of h = Δt/k each                                                           (2)
///     v ← v + φΔt M⁻¹Ψ_s(t+Δt, r)                                                                               (3)
///
/// φ = ½ around velocity Verlet, 0 around symplectic_euler, 1 around its adjoint. Where Ψ_f in (2) has slow terms of its own,
/// each h is such a step again: so all levels are one loop over inner steps, in which term j gets (1) at the beginning
/// of each k_j and (3) at their end. Between two such ends velocity Verlet knows Ψ_s from the one: n outer steps call term
/// j n K/k_j times, K the largest k, and once more at their start; Euler's schemes n K/k_j times.
///
/// Each part of the step is the exact flow of a part of the energy: symplectic, and with φ = ½ symmetric in time, of order 2.
/// It resonates where an outer step is half a period of a fast mode, ωΔt = π, and at multiples of that: a slow force then drives
/// the fast mode, however weak it is and however small h (preflight says up to which Δt none does).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/phi.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/seldom.hpp"
#include "phistep/schemes/velocity_verlet.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/kernel/scheme_on.hpp"
#include "phistep/step/transaction/edit_guard.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// φ in (1) and (3) as halves; −1: this scheme takes no slow terms.
template <class Scheme>
inline constexpr int slow_halves = -1;
template <>
inline constexpr int slow_halves<VelocityVerlet> = 1;
template <>
inline constexpr int slow_halves<std::remove_const_t<decltype(symplectic_euler)>> = 0;
template <>
inline constexpr int slow_halves<std::remove_const_t<decltype(symplectic_euler_adjoint)>> = 2;

/// Whether a stepper of that scheme takes a force as it is.
template <class F, class Scheme>
struct RespaRefusal : Refuses {
  static_assert(SeldomRefusal<F>::is_said);
  static_assert(
      !has_seldom<F> || slow_halves<Scheme> >= 0,
      "phistep: seldom(k, term) makes inner steps of velocity_verlet, symplectic_euler or symplectic_euler_adjoint: an "
      "implicit scheme, and one of a higher order, takes the sum without it");
};

/// (1) to (3) around a scheme's step for the other terms.
template <class Inner, State S, class Rhs, int halves>
class RespaScheme : public SchemeDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Traits = typename Rhs::KickTraits;
  static_assert(Refusal<Traits::fault, Rhs::drifts>::is_said);
  static_assert(
      !Traits::valid || !Traits::uses_velocity,
      "phistep: a term of seldom(k, term) must ignore v: f(r), or a struct with uses_velocity = false; drag and "
      "friction belong to the fast terms");
  static_assert(Rhs::blocks == 1, "phistep: seldom(k, term) needs a motion (r, v) and no other unknowns");
  static_assert(
      !Rhs::slow_terms_have_history,
      "phistep: a term of seldom(k, term) may remember nothing but a neighbour list: friction springs belong to the "
      "fast terms");

  template <class R>
  static constexpr KernelNeeds needs = [] {
    KernelNeeds inner = Inner::template needs<R>;
    inner.passes = 0;
    return inner;
  }();
  static constexpr bool has_inner_steps = true;

  RespaScheme(const auto& scheme, const Plain& y) : inner_{scheme, y} { allocate(y); }
  void resize(const Plain& y) {
    inner_.resize(y);
    allocate(y);
  }
  [[nodiscard]] int order() const { return inner_.order(); }
  /// Evaluations of slow term j, in the order of the sum.
  [[nodiscard]] std::int64_t calls(std::size_t j) const { return levels_[j].calls; }

  void archive(auto& ar) { ar("inner", inner_, "known_at", guard_, "levels", levels_); }
  void forget() {
    inner_.forget();
    forget_slow();
  }

  [[nodiscard]] static bool leaves_force() { return false; }  // the last inner step has

  [[nodiscard]] Outcome step(auto& eq) {
    Rhs& rhs = eq.rhs();
    const int steps = inner_steps(rhs.whole_force());
    const Scalar h = eq.dt / static_cast<Scalar>(steps);
    if (eq.t + h == eq.t) return Outcome::step_too_small;
    const auto time = [&](int i) { return i == steps ? eq.t + eq.dt : eq.t + static_cast<Scalar>(i) * h; };
    // From now to next and back: the last inner step ends in eq.next.
    Plain *now = steps % 2 == 0 ? &eq.next : &other_, *next = steps % 2 == 0 ? &other_ : &eq.next;
    copy_blocks<S>(*now, eq.y);
    if (!guard_.holds(eq.rhs().inside(eq.t), eq.y)) forget_slow();
    guard_.forget();  // an exception leaves Ψ_s half written
    for (int i = 0; i < steps; ++i, std::swap(now, next)) {
      begin_histories(rhs, i, h, time(i), *now);
      if (const Outcome bad = begin_levels(rhs, i, h, time(i), *now); failed(bad)) return end(eq, *now, bad);  // (1)
      auto inside = eq.part(*now, time(i), h, *next);
      if (const Outcome bad = take_step(inner_, inside); failed(bad)) return end(eq, *next, bad);  // (2)
      eq.ends_as(inside);
      rhs.commit_rest(time(i + 1), *next);
      if (const Outcome bad = end_levels(rhs, i + 1, h, time(i + 1), *next); failed(bad))
        return end(eq, *next, bad);  // (3)
    }
    if constexpr (halves == 1) guard_.remember(eq.rhs().inside(eq.t + eq.dt), eq.next);
    return Outcome::success;
  }

 private:
  /// Ψ of one slow term.
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

  /// All that begin here, before any Ψ: a failure message may ask every term.
  void begin_histories(Rhs& rhs, int i, Scalar h, Scalar t, const Plain& y) {
    rhs.begin_rest(t, h, y);
    static_cast<void>(for_each_due(rhs, i, [&](Level&, auto& term, auto& memory) {
      begin_force(unwrap(term), t, static_cast<Scalar>(term.k()) * h, rhs.view(y), memory);
      return Outcome::success;
    }));
  }
  /// (1), of the terms due at inner step i
  [[nodiscard]] Outcome begin_levels(Rhs& rhs, int i, Scalar h, Scalar t, Plain& y) {
    if constexpr (halves == 2) return Outcome::success;
    return for_each_due(rhs, i, [&](Level& level, auto& term, auto& memory) {
      const Outcome outcome =
          kick(rhs, level, term, memory, t, y, (2 - halves) * static_cast<Scalar>(term.k()) * h / 2);
      level.known = false;
      return outcome;
    });
  }
  /// (3), of the terms due at the end of inner step i−1
  [[nodiscard]] Outcome end_levels(Rhs& rhs, int i, Scalar h, Scalar t, Plain& y) {
    return for_each_due(rhs, i, [&](Level& level, auto& term, auto& memory) {
      Outcome outcome = Outcome::success;
      if constexpr (halves != 0)
        outcome = kick(rhs, level, term, memory, t, y, halves * static_cast<Scalar>(term.k()) * h / 2);
      if constexpr (halves == 2) level.known = false;
      if (!failed(outcome)) commit_force(unwrap(term), t, rhs.view(y), memory);
      return outcome;
    });
  }
  /// y.v += γ M⁻¹Ψ_j(t, y)
  [[nodiscard]] Outcome kick(Rhs& rhs, Level& level, auto& term, const auto& memory, Scalar t, Plain& y, Scalar gamma) {
    if (!level.known) {
      ++rhs.statistics().kick_calls;
      ++level.calls;
      assign_force(unwrap(term), t, rhs.view(y), memory, level.psi);
      // Before it spoils what it is added to, so that the message finds the term.
      if (!all_finite(RateOf<S>::blocks(level.psi))) return Outcome::non_finite_force;
      level.known = !ForceTraits<Unwrapped<decltype(term.force)>, typename Rhs::View, RateOf<S>>::is_lookup;
    }
    return kick_blocks<S>(y, gamma, RateOf<S>::blocks(std::as_const(level.psi)), scratch_, rhs.masses())
               ? Outcome::success
               : Outcome::non_finite_state;
  }
  /// f(level, term, its memory) → Outcome for those with k | i, to the first that fails
  [[nodiscard]] Outcome for_each_due(Rhs& rhs, int i, auto&& f) {
    Outcome outcome = Outcome::success;
    rhs.for_each_seldom([&](std::size_t j, auto& term, auto& memory) {
      if (!failed(outcome) && i % term.k() == 0) outcome = f(levels_[j], term, memory);
    });
    return outcome;
  }
  /// The step ends early: next and psi tell the failure message where.
  [[nodiscard, gnu::cold, gnu::noinline]] Outcome end(auto& eq, const Plain& where, Outcome bad) {
    if (&where != &eq.next) copy_blocks<S>(eq.next, where);
    for (const Level& level : levels_)
      if (first_non_finite(RateOf<S>::blocks(level.psi))) eq.psi = level.psi;
    forget_slow();
    return bad;
  }
  void forget_slow() {
    guard_.forget();
    for (Level& level : levels_) level.known = false;
  }
  void allocate(const Plain& y) {
    other_ = y;
    for (Level& level : levels_) level.psi = make_rate<S>(y);
    if constexpr (Rhs::has_matrix_mass || static_unknowns<S> != Eigen::Dynamic) scratch_ = make_rate<S>(y);
    forget_slow();
  }

  Inner inner_;
  Plain other_;
  std::array<Level, Parts<typename Rhs::Whole>::template places<true>.size()> levels_;
  RateOf<S> scratch_;  // only matrix masses write it
  EditGuard<S, true, Traits::uses_time> guard_;
};

}}  // namespace phistep::PHISTEP_ABI
