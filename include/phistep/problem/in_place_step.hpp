/// @file
/// Explicit steps of states in place, without a copy of state or force: Euler's in one pass over the arrays, velocity
/// Verlet's in two. Each pass takes the particles in pieces,
///
///     keep r, v (and f)   →   v⁺ = v + (h/m) f,  r⁺ = r + (before v + after v⁺)   →   write them where they were,
///
/// so that memory is read once and written once; what was kept puts the arrays back if the step fails.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>
#include <type_traits>

#include "phistep/core/outcome.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/version.hpp"
#include "phistep/embed/routine.hpp"
#include "phistep/equation/explicit_update.hpp"
#include "phistep/equation/gamma.hpp"
#include "phistep/problem/transaction.hpp"
#include "phistep/simd/fingerprint.hpp"
#include "phistep/simd/update.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Whether Force is a routine that works on the arrays of S.
template <class S, class Force>
inline constexpr bool is_routine_of = false;
template <class S, class Routine, bool reads_velocities>
inline constexpr bool is_routine_of<S, RoutineForce<S, Routine, reads_velocities>> = true;

/// A kernel for schemes of one or two passes, and the transaction around their steps.
template <State S, class RightHandSideOf, int passes>
class InPlaceStep {
 public:
  using Rhs = RightHandSideOf;
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  static constexpr bool carries = passes == 2;
  struct Data {
    S& state;
    const Scalar t;   ///< [time]
    const Scalar dt;  ///< [time]
    const Origin origin;
    bool psi_next_known = false;
    static constexpr bool is_traced = false;
  };

  /// The force's arrays are those of the state.
  [[nodiscard]] static bool can(Rhs& rhs, const S& state) { return rhs.force().arrays() == &state; }
  /// Ψ is not known where the next step starts.
  void forget() { known_ = Known::nothing; }

  template <class Advance, class Transaction>
  StepReport run(Rhs& rhs, Transaction& transaction, S& state, Scalar t, Scalar dt, Origin origin, Advance&& advance) {
    if (const Outcome bad = transaction.open(t, dt); failed(bad)) return transaction.refuse(rhs, bad, t, dt);
    rhs_ = &rhs;
    state.fit();
    is_kept_ = is_rate_kept_ = false;
    Data data{state, t, dt, origin};
    Undo undo{*this, state};
    const Outcome outcome = advance(*this, data);
    undo.is_done = !failed(outcome);
    if (undo.is_done) {
      ++rhs.statistics().steps;
      return {Outcome::success, 0, nullptr};
    }
    forget();
    transaction.show(state, state.rate());
    put_back(state);
    return transaction.report_shown(rhs, outcome, t, dt, state.kept().y);
  }

  /// The state is y + γ M⁻¹Ψ(t, y), r drifted.
  [[nodiscard]] Outcome kick_drift(Data& step, const Advance<Scalar>& by) {
    const bool unedited = step.origin == Origin::unedited;
    bool known = carries && (unedited ? known_ != Known::nothing : known_ == Known::checked) && same_time(step.t);
    const Seen expected = seen_;
    known_ = Known::nothing;
    if (!known) evaluate(step.state, step.t);
    bool finite = pass<true>(step.state, by, !unedited);
    if (known && !unedited && !(before_ == expected)) {  // edited since
      copy_blocks<S>(step.state, step.state.kept().y);
      evaluate(step.state, step.t);
      finite = pass<true>(step.state, by, true);
    }
    return finite ? Outcome::success : Outcome::non_finite_state;
  }
  /// The state's v is v + γ M⁻¹Ψ(t, r): the step's last pass.
  [[nodiscard]] Outcome resolve(Data& step, const Gamma<Scalar>& gamma, Scalar t) {
    evaluate(step.state, t);
    const bool unedited = step.origin == Origin::unedited;
    if (!pass<false>(step.state, {gamma.force, 0, 0}, !unedited)) return Outcome::non_finite_state;
    known_ = unedited ? Known::unchecked : Known::checked;
    t_ = t;
    return Outcome::success;
  }

 private:
  static constexpr bool drifts = Blocks<S>::drifts;
  static constexpr std::size_t last = drifts ? 1 : 0;  // the solved block
  using Block = std::remove_cvref_t<decltype(std::declval<S&>().rate())>;
  static constexpr Index dim = Block::dim;
  enum class Known : std::uint8_t { nothing, unchecked, checked };
  /// Positions and forces, by their bits.
  struct Seen {
    std::uint64_t r = 0, psi = 0;
    bool operator==(const Seen&) const = default;
  };
  struct Undo {
    InPlaceStep& step;
    S& state;
    bool is_done = false;
    ~Undo() {
      if (is_done) return;
      step.forget();
      step.put_back(state);
    }
  };
  /// Of a piece that begins at component `at`.
  template <class Factor>
  struct PieceFactor {
    Factor factor;
    Index at;
    auto operator()(Index i) const { return factor(at + i); }
  };

  void put_back(S& state) {
    const bool fits = state.has_kept_lengths();
    if (is_kept_ && fits) copy_blocks<S>(state, std::as_const(state.kept().y));
    if (is_rate_kept_ && fits) state.put_back_rate();
    is_kept_ = is_rate_kept_ = false;
  }
  /// The arrays' forces are Ψ of what else they hold.
  void evaluate(S& state, Scalar t) {
    if (!is_rate_kept_) state.keep_rate();
    is_rate_kept_ = true;
    if (rhs_->force().looks_next() && !is_kept_) {
      copy_blocks<S>(state.kept().y, state);
      is_kept_ = true;
    }
    ++rhs_->statistics().force_calls;
    rhs_->force().call(t);
  }
  [[nodiscard]] bool same_time(Scalar t) const {
    if constexpr (!Rhs::Traits::uses_time) return true;
    else return std::abs(t - t_) <= 8 * std::numeric_limits<Scalar>::epsilon() * std::max(std::abs(t), std::abs(t_));
  }

  /// One pass over all particles; false where a result isn't finite. `first` passes keep what they overwrite.
  /// @param looks  at the bits of positions and forces, so that edits until the next step are noticed
  template <bool first>
  [[nodiscard]] bool pass(S& state, const Advance<Scalar>& by, bool looks) {
    auto blocks = Blocks<S>::all(state);
    const Block psi = state.rate();
    auto& kept = state.kept();
    const auto factor = std::get<0>(rhs_->masses()).scaled(by.kick);
    const bool keeps_rate = first && carries && !is_rate_kept_;
    Scalar r1[places_chunk * dim], v1[places_chunk * dim], piece[places_chunk * dim], v_piece[places_chunk * dim];
    Seen before, after;
    bool finite = true;
    for (Index p = 0; p < psi.count; p += places_chunk) {
      const Index m = std::min(places_chunk, psi.count - p), at = p * dim;
      const PieceFactor<std::remove_cvref_t<decltype(factor)>> scaled{factor, at};
      Scalar* const f = keeps_rate ? kept.rate.data() + at : piece;
      psi.gather(p, m, f);
      auto& moved = std::get<last>(blocks);
      Scalar* const v = first ? std::get<last>(Blocks<S>::all(kept.y)).data() + at : v_piece;
      moved.gather(p, m, v);
      if constexpr (first && drifts) {
        Scalar* const r = std::get<0>(Blocks<S>::all(kept.y)).data() + at;
        std::get<0>(blocks).gather(p, m, r);
        const KickAndDrift kernel{r, v, f, scaled, by.before, by.after};
        finite = update_in_place(m * dim, kernel, v1, r1) && finite;
        std::get<0>(blocks).scatter(r1, p, m);
        if (carries && looks) {
          before.r = fingerprint(r, m * dim, before.r), before.psi = fingerprint(f, m * dim, before.psi);
          after.r = fingerprint(r1, m * dim, after.r);
        }
      } else {
        const Kick kernel{v, f, scaled};
        finite = update_in_place(m * dim, kernel, v1) && finite;
        if (carries && looks) after.psi = fingerprint(f, m * dim, after.psi);
      }
      moved.scatter(v1, p, m);
    }
    if constexpr (first) {
      is_kept_ = true, is_rate_kept_ = is_rate_kept_ || keeps_rate;
      before_ = before, seen_.r = after.r;
    } else {
      seen_.psi = after.psi;
    }
    return finite;
  }

  Rhs* rhs_ = nullptr;  // during a step
  bool is_kept_ = false, is_rate_kept_ = false;
  Known known_ = Known::nothing;
  Scalar t_{};          // [time] where Ψ is known
  Seen seen_, before_;  // what the last step left; what the last first pass found
};

}  // namespace phistep::inline PHISTEP_ABI
