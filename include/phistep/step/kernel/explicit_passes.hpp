/// @file
/// The explicit passes, of which explicit steps consist, and with which implicit ones begin (Equation::forward), each by the cheapest
/// way that the state allows:
///
///     kick_drift   v⁺ = v + γ M⁻¹Ψ(t, y),  r⁺ = r + before v + after v⁺
///     kick         v⁺ = v⁺ + γ M⁻¹Ψ(t, y⁺)
///
/// beside the state; over the active particles alone; into the state itself (in_place_update.hpp); or by the routine of a
/// state in place, a whole step at a time (in_place_step.hpp).
#pragma once

#include <type_traits>
#include <utility>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/in_place/in_place_step.hpp"
#include "phistep/step/in_place/in_place_update.hpp"
#include "phistep/step/in_place/unchanged_particles.hpp"
#include "phistep/step/transaction/transaction.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @tparam carries  Ψ at the end of a step is left in `psi` for the next
template <State S, class RightHandSideOf, KernelNeeds needs, bool carries>
class ExplicitPasses {
 public:
  using Rhs = RightHandSideOf;
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  explicit ExplicitPasses(const S& state) : arrays_{state} {}
  void bind(const Plain& y) {
    if constexpr (keeps_psi) kicked_by_ = make_rate<S>(y);
  }

  /// A scheme of one or two passes under the routine of a state in place: no copies.
  static constexpr bool steps_in_place =
      needs.passes != 0 && !Rhs::has_matrix_mass && is_routine_of<S, typename Rhs::Whole>;
  [[nodiscard]] auto& arrays() { return arrays_; }
  [[nodiscard]] const auto& arrays() const { return arrays_; }

  void begin_step(Rhs& rhs, S& state, Origin origin, bool keeps_tries) {
    if constexpr (steps_in_place) arrays_.forget();
    if constexpr (follows_active) {
      unchanged_.begin_step(origin);
      rhs.set_left_out({});
    }
    if constexpr (writes_in_place) in_place_.begin(keeps_tries ? nullptr : &state, origin == Origin::unedited);
  }
  /// @param done  the step has become the state
  void end_step(bool done) {
    if constexpr (writes_in_place)
      if (done) in_place_.end();
    if constexpr (follows_active) unchanged_.end_step(done);
  }
  /// What is known of where the next step starts. @param stays  but for which particles are outside the active set
  void forget(bool stays = false) {
    if constexpr (steps_in_place) arrays_.forget();
    if constexpr (writes_in_place) in_place_.forget();
    if constexpr (follows_active)
      if (!stays) unchanged_.forget();
  }

  [[nodiscard, gnu::always_inline]] inline Outcome kick_drift(Rhs& rhs, auto& eq, const auto& by) {
    if constexpr (follows_active)
      if (unchanged_.find(rhs.active(), eq.y, eq.next)) rhs.set_left_out(unchanged_.left_out());
    const bool finite = eq.knows_start ? advance_by(rhs, eq, by, RateOf<S>::blocks(std::as_const(eq.psi)))
                                       : advance_by(rhs, eq, by, rhs.evaluate(eq.t, eq.y, eq.psi));
    // A matrix mass used psi as its scratch, and a reference to the user's array never filled it.
    eq.knows_start = !Rhs::has_matrix_mass && (eq.knows_start || !Rhs::returns_reference);
    return finite ? Outcome::success : Outcome::non_finite_state;
  }
  [[nodiscard, gnu::always_inline]] inline Outcome kick(Rhs& rhs, auto& eq, Scalar gamma, Scalar t) {
    if constexpr (!carries) return kick_by(rhs, eq, gamma, rhs.evaluate(t, eq.next, eq.psi));
    rhs.evaluate_into(t, eq.next, eq.psi);  // a copy: the user's own array may change before the next step
    if constexpr (keeps_psi) {
      kicked_by_ = eq.psi;  // psi goes on to the next step as Ψ, not as M⁻¹Ψ
      const bool finite =
          kick_blocks<S>(eq.next, gamma, RateOf<S>::blocks(std::as_const(kicked_by_)), kicked_by_, rhs.masses());
      return finite ? Outcome::success : Outcome::non_finite_state;
    }
    return kick_by(rhs, eq, gamma, RateOf<S>::blocks(std::as_const(eq.psi)));
  }

 private:
  /// A kick whose Ψ is carried must not be scaled by a matrix mass in place.
  static constexpr bool keeps_psi = carries && Rhs::has_matrix_mass;
  /// Not where a matrix mass scales Ψ in a place of its own, nor where a history's commit could still fail after the update.
  static constexpr bool writes_in_place = needs.passes == 1 && !ShowsTrials<S> && !FieldState<S> &&
                                          !Transaction<S, Rhs, carries>::in_registers && !Rhs::remembers &&
                                          !Rhs::has_matrix_mass;
  /// Particles outside the active set are not written.
  static constexpr bool follows_active =
      needs.passes != 0 && !Rhs::has_matrix_mass && Rhs::takes_active && std::is_same_v<S, PlainState<S>>;

  [[nodiscard, gnu::always_inline]] inline bool advance_by(Rhs& rhs, auto& eq, const auto& by, const auto& psi) {
    if constexpr (follows_active)
      if (const auto* only = unchanged_.found())
        return advance_particles<S>(eq.next, eq.y, by, psi, rhs.masses(), *only);
    if constexpr (writes_in_place)
      if ((eq.is_state_next = in_place_.advance(rhs, eq.y, by, psi))) return true;
    return advance_blocks<S>(eq.next, eq.y, by, psi, eq.psi, eq.masses);
  }
  [[nodiscard, gnu::always_inline]] inline Outcome kick_by(Rhs& rhs, auto& eq, Scalar gamma, const auto& psi) {
    if constexpr (follows_active)
      if (const auto* only = unchanged_.found())
        return advance_particles<S, false>(eq.next, eq.next, {gamma, 0, 0}, psi, rhs.masses(), *only)
                   ? Outcome::success
                   : Outcome::non_finite_state;
    return kick_blocks<S>(eq.next, gamma, psi, eq.psi, eq.masses) ? Outcome::success : Outcome::non_finite_state;
  }

  [[no_unique_address]] Only<steps_in_place, InPlaceStep<S, Rhs, needs.passes>> arrays_;
  [[no_unique_address]] Only<keeps_psi, RateOf<S>> kicked_by_{};
  [[no_unique_address]] Only<writes_in_place, InPlaceUpdate<S, Rhs>> in_place_{};
  [[no_unique_address]] Only<follows_active, UnchangedParticles<S>> unchanged_{};
};

}}  // namespace phistep::PHISTEP_ABI
