/// @file
/// M y' = Ψ(t, y): a force bound to a state's shape, its masses and its history. The primitive `evaluate`.
#pragma once

#include <memory>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/force/at.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/mass/bound_masses.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Holds a value that can be assigned though its type is a lambda with captures: it is made anew in its place. It can't be
/// assigned where a copy may throw.
template <class T>
class Assignable {
 public:
  explicit Assignable(T value) : value_{std::move(value)} {}
  Assignable(const Assignable&) = default;
  Assignable(Assignable&&) = default;
  Assignable& operator=(const Assignable&) requires std::is_copy_assignable_v<T>
  = default;
  Assignable& operator=(Assignable&&) requires std::is_move_assignable_v<T>
  = default;
  Assignable& operator=(const Assignable& other) requires(!std::is_copy_assignable_v<T> &&
                                                          std::is_nothrow_copy_constructible_v<T>) {
    if (this == &other) return *this;
    std::destroy_at(&value_);
    std::construct_at(&value_, other.value_);
    return *this;
  }
  ~Assignable() = default;

  [[nodiscard]] T& operator*() { return value_; }
  [[nodiscard]] const T& operator*() const { return value_; }

 private:
  T value_;
};

/// @tparam split  the force is a sum, some of whose terms enter as kicks: Ψ is then the sum of the others
template <State S, class F, class MassTuple, bool split = false>
class RightHandSide {
  struct OnePart {
    using Rest = Unwrapped<F>;
    using Kicks = Sum<>;
  };
  using Split = std::conditional_t<split, Parts<Unwrapped<F>>, OnePart>;

 public:
  using ArchivedByParts = void;
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Masses = MassTuple;
  using Whole = Unwrapped<F>;
  using Force = typename Split::Rest;
  using Kicks = typename Split::Kicks;
  /// Ψ is made of several terms among the kicks.
  static constexpr bool gathers = [] {
    if constexpr (split) return Parts<Whole>::template places<false>.size() != 1;
    else return false;
  }();
  using View = decltype(Blocks<S>::view(std::declval<const Plain&>(), std::declval<const Masses&>()));
  using Traits = ForceTraits<Force, std::remove_cvref_t<View>, Rate>;
  using KickTraits = ForceTraits<Kicks, std::remove_cvref_t<View>, Rate>;
  using Memory = MemoryOf<F>;
  static constexpr bool remembers = phistep::remembers<F>, has_history = phistep::has_history<F>;
  /// The kicks are slow terms (force/at.hpp): a step has inner steps, and each term's history begins and ends with its own.
  static constexpr bool has_inner_steps = split && has_seldom<Whole>;
  static constexpr bool slow_terms_have_history = split && phistep::has_history<Kicks>;
  static constexpr bool drifts = Blocks<S>::drifts;
  static constexpr std::size_t blocks = solved_blocks<S>;
  using MassTypes = MassFacts<Masses, Scalar>;
  static constexpr bool has_matrix_mass = MassTypes::has_matrix;
  static constexpr Structure mass_structure = MassTypes::structure;
  /// M may turn out to be singular, so that some of the equations are algebraic.
  static constexpr bool may_be_singular = !drifts && MassTypes::may_be_singular;
  static constexpr bool takes_active =
      requires(std::tuple_element_t<0, Masses> & mass, std::shared_ptr<const ActiveSet> active) {
    mass.set_active(active);
  };
  static constexpr bool is_autonomous = !Traits::uses_time;
  /// Ψ or a kick uses the time.
  static constexpr bool uses_time = Traits::uses_time || (split && KickTraits::uses_time);
  /// Whether Ψ depends on the unknowns themselves, and not on r alone.
  static constexpr bool couples_unknowns = !drifts || Traits::uses_velocity || blocks > 1;

  RightHandSide(F f, Masses masses) : force_{std::move(f)}, masses_{std::move(masses)} {
    if constexpr (FieldState<Plain>) held_ = std::make_shared<HeldException>();
  }

  /// What Ψ is made of.
  [[nodiscard]] auto& force() {
    if constexpr (!split) return unwrap(*force_);
    else if constexpr (!gathers) return Parts<Whole>::template of<false>(unwrap(*force_));
    else return rest_.emplace(Parts<Whole>::template of<false>(unwrap(*force_)));
  }
  /// The force as the user gave it, kicks included.
  [[nodiscard]] auto& whole_force() { return unwrap(*force_); }
  [[nodiscard]] const Masses& masses() const { return masses_; }
  [[nodiscard]] Statistics& statistics() { return statistics_; }
  [[nodiscard]] const Statistics& statistics() const { return statistics_; }
  [[nodiscard]] View view(const Plain& y) const { return Blocks<S>::view(y, masses_); }

  /// The committed history, by value: part of a checkpoint.
  [[nodiscard]] const Memory& memory() const { return committed_; }
  void set_memory(Memory memory) { committed_ = std::move(memory); }
  void archive(auto& ar) {
    ar.open("memory");
    archive_memory<Whole>(ar, committed_);
    ar.close();
    ar("counts", statistics_);
  }
  /// The history that Ψ sees during a step.
  [[nodiscard]] decltype(auto) trial_memory() const {
    if constexpr (split) return Parts<Whole>::template memory<false>(trial_);
    else return (trial_);
  }
  /// The times of the step to come, which may start or end where Ψ jumps.
  void limit_times(Scalar t, Scalar dt, const Origin& origin) {
    if constexpr (uses_time) times_ = Times<Scalar>{t, dt, origin};
  }
  /// t, or the time next to it inside the step. [time]
  [[nodiscard]] Scalar inside(Scalar t) const {
    if constexpr (uses_time) return times_(t);
    else return t;
  }
  void begin(Scalar t, Scalar dt, const Plain& y) {
    if constexpr (remembers) {
      trial_ = committed_;
      if constexpr (!has_inner_steps) begin_force(whole_force(), t, dt, view(y), trial_);
    }
  }
  void commit(Scalar t, const Plain& accepted) {
    if constexpr (remembers) {
      if constexpr (!has_inner_steps) commit_force(whole_force(), t, view(accepted), trial_);
      std::swap(committed_, trial_);
    }
  }
  /// An inner step begins, or is done: within the trial history, so that the committed one outlives a step that fails.
  void begin_rest(Scalar t, Scalar dt, const Plain& y) {
    if constexpr (remembers) {
      auto&& memory = Parts<Whole>::template memory<false>(trial_);
      begin_force(force(), t, dt, view(y), memory);
    }
  }
  void commit_rest(Scalar t, const Plain& accepted) {
    if constexpr (remembers) {
      auto&& memory = Parts<Whole>::template memory<false>(trial_);
      commit_force(force(), t, view(accepted), memory);
    }
  }
  /// f(j, slow term j, its trial history)
  void for_each_seldom(auto&& f) {
    constexpr auto places = Parts<Whole>::template places<true>;
    [&]<std::size_t... J>(std::index_sequence<J...>) {
      (f(J, std::get<places[J]>(whole_force().terms), memory_of_term<places[J]>(trial_)), ...);
    }
    (std::make_index_sequence<places.size()>{});
  }

  /// Ψ(t, y), as a tie of its blocks: of `psi`, or of the user's own array where the force returns a reference to one.
  [[nodiscard]] auto evaluate(Scalar t, const Plain& y, Rate& psi) {
    if constexpr (returns_reference) {
      ++statistics_.force_calls;
      const auto& result = returned_force(force(), view(y), inside(t), psi);
      check_result_size(result, std::get<0>(Rate::blocks(psi)));
      return std::tie(result);
    } else {
      evaluate_into(t, y, psi);
      return Rate::blocks(std::as_const(psi));
    }
  }
  /// psi = Ψ(t, y), always copied.
  void evaluate_into(Scalar t, const Plain& y, Rate& psi) {
    ++statistics_.force_calls;
    if constexpr (FieldState<Plain>) {
      held_->run([&] { assign_force(force(), inside(t), view(y), trial_memory(), psi); },
                 [&] { for_each_block([](auto, auto& block) { block.poison(); }, Rate::blocks(psi)); });
    } else {
      assign_force(force(), inside(t), view(y), trial_memory(), psi);
    }
  }
  /// What the force, or a solver, of a field has thrown on this rank.
  [[nodiscard]] const std::shared_ptr<HeldException>& held() const requires FieldState<Plain> { return held_; }
  /// psi = Ψ_e(t, y), the kicks.
  void evaluate_kicks(Scalar t, const Plain& y, Rate& psi) {
    ++statistics_.kick_calls;
    auto&& kicks = Parts<Whole>::template of<true>(unwrap(*force_));
    assign_force(kicks, inside(t), view(y), Parts<Whole>::template memory<true>(trial_), psi);
  }

  /// out = y' = (v, M⁻¹Ψ), by a force call. False: it isn't finite.
  [[nodiscard]] bool slope(Scalar t, const Plain& y, Plain& out, Rate& psi) {
    evaluate_into(t, y, psi);
    if constexpr (drifts) std::get<0>(Blocks<S>::all(out)) = std::get<1>(Blocks<S>::all(y));
    const auto rates = Blocks<S>::solved(out);
    for_each_block([](auto, auto& to, const auto& rate) { to = rate; }, rates, Rate::blocks(psi));
    const bool finite = all_finite(rates);
    return divide_by_mass(rates, masses_) && finite;
  }
  /// The same between steps, with the kicks of a split scene.
  [[nodiscard]] bool whole_slope(Scalar t, const Plain& y, Plain& out, Rate& psi) {
    limit_times(t, Scalar{0}, Origin::unknown);
    begin(t, Scalar{0}, y);  // a force may make its history at its first step
    if constexpr (remembers && has_inner_steps) begin_force(whole_force(), t, Scalar{0}, view(y), trial_);
    bool finite = slope(t, y, out, psi);
    if constexpr (split) {
      evaluate_kicks(t, y, psi);
      finite = kick_blocks<S>(out, Scalar{1}, Rate::blocks(std::as_const(psi)), psi, masses_) && finite;
    }
    return finite;
  }

  [[nodiscard]] static bool is_finite(const Plain& y) { return all_finite(Blocks<S>::all(y)); }
  void rebind(Masses masses) { masses_ = std::move(masses); }
  /// The particles that are computed from now on (base/state/active_set.hpp): hands the set to the masses that take one. True where
  /// it has a particle that the set before had not.
  bool set_active(const std::shared_ptr<const ActiveSet>& active) requires takes_active {
    bool more = false;
    std::apply(
        [&](auto&... mass) {
          const auto set = [&](auto& one) {
            if constexpr (requires { one.set_active(active); }) more = one.set_active(active) || more;
          };
          (set(mass), ...);
        },
        masses_);
    return more;
  }

  [[nodiscard]] const ActiveSet* active() const requires takes_active { return std::get<0>(masses_).active(); }
  /// What is known of particles outside the active set, for forces to see.
  void set_left_out(const LeftOut& known) requires takes_active {
    if (std::get<0>(masses_).left_out != known) std::get<0>(masses_).left_out = known;
  }

  /// Which term of a sum spoils Ψ at (t, y), for messages; −1 where that isn't known.
  [[nodiscard]] int offending_term(Scalar t, const Plain& y) {
    if constexpr (FieldState<Plain>) return -1;  // ranks might not agree on it
    Rate scratch = make_rate<S>(y);
    try {
      return phistep::offending_term(whole_force(), t, view(y), trial_, scratch);
    } catch (...) {  // the caller is already reporting a failure; asking again must not add another
      return -1;
    }
  }

  /// Where Ψ was read from the user's own array, the workspace doesn't show it: Ψ is read again.
  [[nodiscard]] bool is_non_finite_at(Scalar t, const Plain& y, ComponentLocation& where) {
    if constexpr (returns_reference) {
      try {
        Rate scratch = make_rate<S>(y);
        assign_force(force(), t, view(y), trial_memory(), scratch);  // uncounted: part of the message, not of the step
        where = first_non_finite(Rate::blocks(scratch));
      } catch (...) {
        return false;
      }
    }
    return static_cast<bool>(where);
  }

  static constexpr bool returns_reference = [] {
    if constexpr (Traits::accumulates || !Traits::valid || has_matrix_mass || FieldState<Plain>) {
      return false;
    } else {
      using Result = decltype(call_with<Traits::arity>(std::declval<Force&>(), std::declval<View&>(), Scalar{}));
      return std::is_lvalue_reference_v<Result> &&
             std::is_same_v<std::remove_cvref_t<Result>,
                            std::remove_cvref_t<decltype(std::get<0>(Rate::blocks(std::declval<Rate&>())))>>;
    }
  }();

 private:
  Assignable<F> force_;
  [[no_unique_address]] Only<gathers, std::optional<Force>> rest_;  // made anew at each use
  [[no_unique_address]] Masses masses_;
  [[no_unique_address]] Memory committed_{};
  [[no_unique_address]] Memory trial_{};
  [[no_unique_address]] Only<FieldState<Plain>, std::shared_ptr<HeldException>> held_;
  [[no_unique_address]] Only<uses_time, Times<Scalar>> times_;
  Statistics statistics_;
};

}}  // namespace phistep::PHISTEP_ABI
