/// @file
/// Explicit steps of states in place, without a copy of state or force: Euler's in one pass over the arrays, velocity
/// Verlet's in two. A pass reads each number once and writes it where it was,
///
///     kept ← r, v, f   →   v⁺ = v + (h/m) f,   r⁺ = r + (before v + after v⁺)   →   r, v,
///
/// piece by piece, and what it keeps puts the arrays back if the step fails.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/numbers/fingerprint.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/update.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/strided_block.hpp"
#include "phistep/force/routine.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/transaction/edit_guard.hpp"
#include "phistep/step/transaction/transaction.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Whether Force is a routine that works on the arrays of S.
template <class S, class Force>
inline constexpr bool is_routine_of = false;
template <class S, class Routine, bool reads_velocities>
inline constexpr bool is_routine_of<S, RoutineForce<S, Routine, reads_velocities>> = true;

/// What steps overwrite of a state's arrays: the numbers of the solved block, of the positions where the state has them, and of
/// the forces, vector by vector, or component by component where each has an array of its own (x[n], y[n], z[n]).
template <State S>
class UndoLog {
 public:
  using Scalar = ScalarOf<S>;
  static constexpr bool drifts = Blocks<S>::drifts;
  static constexpr std::size_t solved = drifts ? 1 : 0;  ///< which block

  /// A step begins. False where the arrays lie otherwise than in the step before, or have another length.
  bool begin(const S& state) {
    const Index n = state.rate().size();
    const auto blocks = Blocks<S>::all(state);
    const bool apart = state.rate().has_components() && std::get<0>(blocks).has_components() &&
                       std::get<solved>(blocks).has_components();
    const bool same = n == psi_.size() && apart == std::exchange(by_components_, apart);
    if (!same) {
      for (Numbers* all : {&v_, &psi_, &psi_next_}) all->resize(n);
      if constexpr (drifts) r_.resize(n);
      forget();
    }
    has_state_ = has_next_ = false;
    return same;
  }
  /// The forces of the arrays have changed since.
  void forget() { has_psi_ = false; }
  /// The step is done.
  void accept() {
    if (has_next_) psi_.swap(psi_next_);
    has_psi_ = has_next_;
  }
  /// Keeps the forces as the arrays have them, unless the last step has done so.
  void keep_rate(S& state) {
    if (!std::exchange(has_psi_, true)) take(state.rate(), psi_);
  }
  /// Keeps r and v likewise.
  void keep_state(S& state) {
    if (std::exchange(has_state_, true)) return;
    auto blocks = Blocks<S>::all(state);
    if constexpr (drifts) take(std::get<0>(blocks), r_);
    take(std::get<solved>(blocks), v_);
  }
  void put_back_state(S& state) {
    if (!std::exchange(has_state_, false)) return;
    auto blocks = Blocks<S>::all(state);
    if constexpr (drifts) give(r_, std::get<0>(blocks));
    give(v_, std::get<solved>(blocks));
  }
  void put_back(S& state) {
    put_back_state(state);
    if (has_psi_) give(psi_, state.rate());
  }

  [[nodiscard]] const Scalar* psi() const { return psi_.data(); }
  [[nodiscard]] bool by_components() const { return by_components_; }

  /// For a pass: where it keeps what it overwrites, from number `at` on. (To stream it past the caches gains nothing.)
  struct Piece {
    Scalar *r, *v, *psi;
  };
  [[nodiscard]] Piece piece(Index at) {
    return {drifts ? r_.data() + at : nullptr, v_.data() + at, psi_next_.data() + at};
  }
  /// A pass has kept these.
  void kept(bool state, bool psi) {
    has_state_ = has_state_ || state;
    has_next_ = has_next_ || psi;
  }

 private:
  using Numbers = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  void take(const auto& from, Numbers& to) const {
    if (!by_components_) return from.gather(0, from.count, to.data());
    Scalar* next = to.data();
    for (const Scalar* component : from.at) next = std::copy_n(component, from.count, next);
  }
  void give(const Numbers& from, const auto& to) const {
    if (!by_components_) return to.scatter(from.data(), 0, to.count);
    const Scalar* next = from.data();
    for (Scalar* component : to.at) std::copy_n(next, to.count, component), next += to.count;
  }

  Numbers r_, v_, psi_, psi_next_;
  bool by_components_ = false, has_state_ = false, has_psi_ = false, has_next_ = false;
};

/// to[i] = x, a number or a packet of them.
template <class Scalar>
void put_number(Index i, Scalar x, Scalar* to) {
  to[i] = x;
}
template <class Scalar, int width>
void put_number(From<Scalar, width> i, Pack<Scalar, width> x, Scalar* to) {
  x.store(to + i.i);
}

/// Fingerprints of the positions as a pass has found and as it has left them.
struct PositionsSeen {
  std::uint64_t found = 0, left = 0;
};

/// One pass over the arrays. False where a result isn't finite.
/// @tparam keeps_state  it is a step's first pass: r and v are kept, and positions move
/// @param factor  component ↦ h/m, components counted vector by vector
/// @param known   Ψ from the log, null: from the arrays
/// @param seen    null: the bits of the positions are not compared
template <bool keeps_state, bool keeps_psi, State S>
[[nodiscard]] bool pass_in_place(S& state, UndoLog<S>& log, auto factor, const auto& by, const ScalarOf<S>* known,
                                 PositionsSeen* seen) {
  using Scalar = ScalarOf<S>;
  using Block = std::remove_cvref_t<decltype(state.rate())>;
  constexpr bool moves = keeps_state && Blocks<S>::drifts;
  constexpr Index dim = Block::dim, chunk = places_chunk<Block::dim>;
  const Block v{std::get<UndoLog<S>::solved>(Blocks<S>::all(state))}, r{std::get<0>(Blocks<S>::all(state))},
      psi{state.rate()};
  bool finite = true;
  // pass(kernel, v, r) of numbers that follow one another, from number `at` of the log on; the kernel keeps what it overwrites.
  // own(i) is the factor of the i-th.
  const auto update = [&](Index at, const auto& own, Scalar* v1, Scalar* r1, const Scalar* f,
                          auto&& pass) PHISTEP_DETAIL_INLINED {
    const Input<Scalar> v0{v1}, r0{r1}, psi0{known != nullptr ? known + at : f};
    const auto kernel = [=, kept = log.piece(at)](auto i, auto& v_new, auto&... r_new) PHISTEP_DETAIL_INLINED {
      if constexpr (keeps_state) put_number(i, v0[i], kept.v);
      if constexpr (keeps_psi) put_number(i, psi0[i], kept.psi);
      if constexpr (moves) {
        put_number(i, r0[i], kept.r);
        KickAndDrift{r0, v0, psi0, own, by.before, by.after}(i, v_new, r_new...);
      } else {
        Kick{v0, psi0, own}(i, v_new);
      }
    };
    if constexpr (moves) finite = pass(kernel, v1, r1) && finite;
    else finite = pass(kernel, v1) && finite;
  };
  const bool is_whole = v.is_contiguous() && r.is_contiguous() && psi.is_contiguous(),
             by_vectors = v.is_adjacent() && r.is_adjacent() && psi.is_adjacent();
  const auto own_from = [&factor](Index at) PHISTEP_DETAIL_INLINED {
    return [=](auto j) PHISTEP_DETAIL_INLINED { return factor(j + at); };
  };
  Scalar rooms[3][static_cast<std::size_t>(chunk * dim)];
  for (Index p = 0; p < psi.count; p += chunk) {
    const Index m = std::min(chunk, psi.count - p), n = m * dim, at = p * dim;
    const auto in_a_row = [n](const auto& kernel, auto*... to) { return update_in_place(n, kernel, to...); };
    if (is_whole) {
      update(at, own_from(at), v.at[0] + at, r.at[0] + at, psi.at[0] + at, in_a_row);
    } else if (log.by_components()) {
      for (std::size_t d = 0; d < dim; ++d) {
        const Index first = at + static_cast<Index>(d), logged = static_cast<Index>(d) * psi.count + p;
        // Factors of one component are no neighbours: no packets.
        update(
            logged, [factor, first](Index j) { return factor(first + j * dim); }, v.at[d] + p, r.at[d] + p,
            psi.at[d] + p,
            [m](const auto& kernel, auto*... to) {
              return update_in_place(
                  m, [&kernel](Index i, auto&... out) { kernel(i, out...); }, to...);
            });
      }
    } else if (by_vectors) {
      for (Index i = p; i < p + m; ++i)
        update(i * dim, own_from(i * dim), v.at[0] + i * v.stride, r.at[0] + i * r.stride, psi.at[0] + i * psi.stride,
               [](const auto& kernel, auto*... to) { return update_unrolled<dim>(kernel, to...); });
    } else {
      v.gather(p, m, rooms[0]), r.gather(p, m, rooms[1]), psi.gather(p, m, rooms[2]);
      update(at, own_from(at), rooms[0], rooms[1], rooms[2], in_a_row);
      v.scatter(rooms[0], p, m);
      if constexpr (moves) r.scatter(rooms[1], p, m);
    }
    if (moves && seen != nullptr) {
      const auto see = [&seen](const Scalar* found, const Scalar* left, Index count) {
        seen->found = fingerprint(found, count, seen->found), seen->left = fingerprint(left, count, seen->left);
      };
      if (log.by_components()) {
        for (std::size_t d = 0; d < dim; ++d) see(log.piece(static_cast<Index>(d) * psi.count + p).r, r.at[d] + p, m);
      } else {
        r.gather(p, m, rooms[1]);
        see(log.piece(at).r, rooms[1], n);
      }
    }
  }
  log.kept(keeps_state, keeps_psi);
  return finite;
}

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

    /// The state becomes y + γ M⁻¹Ψ(t, y); of a motion v does so, and r drifts.
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
  StepReport take(Rhs& rhs, Transaction& transaction, S& state, Scalar t, Scalar dt, Origin origin, Advance&& advance) {
    if (const Outcome bad = transaction.open(t, dt); failed(bad)) return transaction.refuse(rhs, bad, t, dt);
    rhs_ = &rhs;
    state.note_length();
    if (!log_.begin(state)) known_ = Known::nothing;
    rhs.limit_times(t, dt, origin);
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
      const std::uint64_t left = seen_.left;
      finite = pass<true, !carries>(step, by, looks, log_.psi());
      if (looks && seen_.found != left) {  // edited since
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
    PositionsSeen seen;
    const auto factor = std::get<0>(rhs_->masses()).h_over_mass(by.kick);
    const bool finite =
        pass_in_place<keeps_state, keeps_psi>(step.state, log_, factor, by, psi, looks ? &seen : nullptr);
    if constexpr (keeps_state) seen_ = seen;
    return finite;
  }

  Rhs* rhs_ = nullptr;  // valid during a step only
  UndoLog<S> log_;
  Known known_ = Known::nothing;  // whether the log has Ψ of what the last step left …
  Scalar t_{};                    // [time] … at this time
  PositionsSeen seen_;            // by the last pass that moved them
};

}}  // namespace phistep::PHISTEP_ABI
