/// @file
/// Terms at φ = 0 in an implicit scene, Ψ = Ψ_s + Ψ_e: Strang's splitting (SIAM J. Numer. Anal. 5 (1968) 506; with φ = ½
/// inside it is IMEX of Zhang & Schlick, J. Comput. Chem. 14 (1993) 1212, and Stern & Grinspun, MMS 7 (2009) 1779),
///
///     v½ = v + ½Δt M⁻¹Ψ_e(t, r),   the scheme's step for Ψ_s from (r, v½) to (r⁺, v'),                           (1)
///     v⁺ = v' + ½Δt M⁻¹Ψ_e(t+Δt, r⁺)                                                                             (2)
///
/// of order 2 where the inner scheme is, and with φ = ½ stable for Δt ω_e < 2 whatever Ψ_s. Ψ_e in (2) is the next step's
/// in (1), so that a step calls Ψ_e once; a constant Ψ_e is called once for all. Where Ψ_e depends on what it moves (on v;
/// on y of a first-order state), each half is one explicit midpoint step with t held, two calls:
///
///     k = y + ¼Δt M⁻¹Ψ_e(t, y),   y½ = y + ½Δt M⁻¹Ψ_e(t, k)                                                      (3)
///
/// Take φ = ½ inside. A scheme that damps stiff modes (φ > ½, TR-BDF2) takes away, step by step, what the kicks put into
/// them: in the stiff limit it is then of order 1, and a stiff pendulum under gravity loses its swing.
#pragma once

#include <algorithm>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/only.hpp"
#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/kernel/scheme_on.hpp"
#include "phistep/step/transaction/edit_guard.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Half kicks around another row.
template <class Inner, State S, class Rhs>
class SplitScheme : public SchemeDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Traits = typename Rhs::KickTraits;
  static_assert(Refusal<Traits::fault, Rhs::drifts>::is_said);  // of a term in at(forward_euler, term)

  /// Ψ_e depends on what the kicks move.
  static constexpr bool couples = !Rhs::drifts || Traits::uses_velocity || Rhs::blocks > 1;
  static constexpr bool reuses = !couples && !Rhs::has_history;
  static constexpr bool is_constant = reuses && !Traits::uses_time && Traits::structure == Structure::none;

  /// The inner scheme may carry Ψ_s over the kicks where that ignores what they move.
  template <class R>
  static constexpr KernelNeeds needs = [] {
    KernelNeeds inner = Inner::template needs<R>;
    inner.carries = inner.carries && !R::couples_unknowns;
    inner.passes = 0;
    return inner;
  }();

  SplitScheme(const auto& scheme, const Plain& y) : inner_{scheme, y} { allocate(y); }
  void resize(const Plain& y) {
    inner_.resize(y);
    allocate(y);
  }
  [[nodiscard]] int order() const { return std::min(2, inner_.order()); }
  /// The scheme between the kicks.
  [[nodiscard]] const Inner& inner() const { return inner_; }

  using Progress = typename Inner::Progress;
  [[nodiscard]] Progress progress() const { return inner_.progress(); }
  void resume(Progress progress) { inner_.resume(progress); }
  void archive(auto& ar) {
    ar("inner", inner_, "known_at", guard_, "known", known_);
    ar.in_place("kicks", psi_);
  }
  static constexpr bool traces = false;  // to estimate its error, a split step is doubled
  void reset() { inner_.reset(); }
  void accepted() { inner_.accepted(); }
  void forget() {
    inner_.forget();
    guard_.forget();
    known_ = false;
  }

  [[nodiscard]] static bool leaves_force() { return false; }  // the scheme between the kicks has

  [[nodiscard]] Outcome step(auto& eq) {
    const Scalar half = eq.dt / 2, t1 = eq.t + eq.dt;
    // What a failed step leaves in psi_ is Ψ_e at the place that the guard names, and so may stay.
    known_ = is_constant ? known_ : reuses && guard_.holds(eq.rhs().inside(eq.t), eq.y);
    copy_blocks<S>(kicked_, eq.y);
    if (const Outcome outcome = kick(eq, kicked_, half, eq.t); outcome != Outcome::success) {  // (1)
      copy_blocks<S>(eq.next, kicked_);  // kept for the failure message
      eq.psi = psi_;
      return outcome;
    }
    auto inside = eq.part(kicked_, eq.t, eq.dt, eq.next);
    if (const Outcome bad = take_step(inner_, inside); failed(bad)) return bad;
    eq.ends_as(inside);
    known_ = is_constant;
    if (const Outcome outcome = kick(eq, eq.next, half, t1); outcome != Outcome::success) return outcome;  // (2)
    if constexpr (reuses && !is_constant) guard_.remember(eq.rhs().inside(t1), eq.next);
    return Outcome::success;
  }

 private:
  /// y.solved += γ M⁻¹Ψ_e(t, y), or the explicit midpoint rule for it
  [[nodiscard]] Outcome kick(auto& eq, Plain& y, Scalar gamma, Scalar t) {
    Rhs& rhs = eq.rhs();
    if (!known_) {
      if constexpr (reuses) guard_.forget();  // an exception leaves psi_ half written
      rhs.evaluate_kicks(t, y, psi_);
      if (!finite(eq)) return Outcome::non_finite_force;
      known_ = is_constant;
    }
    if constexpr (couples) {
      copy_blocks<S>(middle_, y);
      static_cast<void>(
          kick_blocks<S>(middle_, gamma / 2, RateOf<S>::blocks(std::as_const(psi_)), scratch_, rhs.masses()));
      rhs.evaluate_kicks(t, middle_, psi_);  // (3)
      if (!finite(eq)) return Outcome::non_finite_force;
    }
    return kick_blocks<S>(y, gamma, RateOf<S>::blocks(std::as_const(psi_)), scratch_, rhs.masses())
               ? Outcome::success
               : Outcome::non_finite_state;
  }
  /// Looked at before it spoils what it is added to, so that the message finds the term.
  [[nodiscard]] bool finite(auto& eq) const {
    const bool all = all_finite(RateOf<S>::blocks(psi_));
    if (!all) eq.psi = psi_;
    return all;
  }
  void allocate(const Plain& y) {
    kicked_ = y;
    psi_ = make_rate<S>(y);
    if constexpr (couples) middle_ = y;
    // A fixed-size state is copied whole, and so filled whole.
    if constexpr (Rhs::has_matrix_mass || static_unknowns<S> != Eigen::Dynamic) scratch_ = psi_;
    guard_.forget();
    known_ = false;
  }

  Inner inner_;
  Plain kicked_;
  [[no_unique_address]] Only<couples, Plain> middle_;
  RateOf<S> psi_, scratch_;  // scratch_: only matrix masses write it
  EditGuard<S, true, Traits::uses_time> guard_;
  bool known_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
