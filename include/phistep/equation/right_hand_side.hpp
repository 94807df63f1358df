/// @file
/// M y' = Ψ(t, y): a force bound to a state's shape, its masses and its history. The primitive `evaluate`, and the
/// explicit update built on it.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/archive/archive.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/equation/assignable.hpp"
#include "phistep/equation/explicit_update.hpp"
#include "phistep/equation/gamma.hpp"
#include "phistep/force/at.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/force/seldom.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/linear/mass.hpp"
#include "phistep/simd/update.hpp"
#include "phistep/state/active_set.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/parts.hpp"
#include "phistep/state/ranks.hpp"
#include "phistep/state/unknowns.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The masses of the solved blocks, bound to their sizes.
template <State S, class Plain>
[[nodiscard]] auto bind_masses(const UnitMasses&, const Plain& y) {
  if constexpr (requires { S::masses(y); }) return S::masses(y);  // the state has its own
  else return []<std::size_t... K>(std::index_sequence<K...>) {
      return std::tuple{(static_cast<void>(K), UnitMass{})...};
    }
  (std::make_index_sequence<solved_blocks<S>>{});
}
template <State S, class... M, class Plain>
[[nodiscard]] auto bind_masses(const MassList<M...>& list, const Plain& y) {
  static_assert(sizeof...(M) == solved_blocks<S>, "phistep: give one mass per solved block of the state");
  if constexpr (sizeof...(M) == solved_blocks<S>) {
    const auto blocks = Blocks<S>::solved(y);
    return [&]<std::size_t... K>(std::index_sequence<K...>) {
      return std::tuple{std::get<K>(list.masses).template bind<ScalarOf<S>>(std::get<K>(blocks))...};
    }
    (std::index_sequence_for<M...>{});
  } else {
    return bind_masses<S>(UnitMasses{}, y);  // so that there is one message only
  }
}

/// @tparam split  the force is a sum, some of whose terms enter as kicks: Ψ is then the sum of the others
template <State S, class F, class MassTuple, bool split = false>
class RightHandSide {
  template <class Whole>
  static auto rest_type() {
    if constexpr (split) return std::type_identity<typename Parts<Whole>::Rest>{};
    else return std::type_identity<Whole>{};
  }
  template <class Whole>
  static auto kicks_type() {
    if constexpr (split) return std::type_identity<typename Parts<Whole>::Kicks>{};
    else return std::type_identity<Sum<>>{};
  }

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Masses = MassTuple;
  using Whole = Unwrapped<F>;
  using Force = typename decltype(rest_type<Whole>())::type;
  using Kicks = typename decltype(kicks_type<Whole>())::type;
  /// Ψ is made of several terms among the kicks.
  static constexpr bool gathers = [] {
    if constexpr (split) return Parts<Whole>::template places<false>.size() != 1;
    else return false;
  }();
  using View = decltype(Blocks<S>::view(std::declval<const Plain&>(), std::declval<const Masses&>()));
  using Traits = ForceTraits<Force, std::remove_cvref_t<View>, Rate>;
  using KickTraits = ForceTraits<Kicks, std::remove_cvref_t<View>, Rate>;
  using Memory = MemoryOf<F>;
  static_assert([]<class... M>(std::type_identity<std::tuple<M...>>) {
    return (BoundMass<M, Scalar> && ...);
  }(std::type_identity<MassTuple>{}));

  static constexpr bool remembers = phistep::remembers<F>, has_history = phistep::has_history<F>;
  /// The kicks are slow terms (force/seldom.hpp): a step has inner steps, and each term's history begins and ends with its own.
  static constexpr bool has_inner_steps = split && has_seldom<Whole>;
  static constexpr bool slow_terms_have_history = split && phistep::has_history<Kicks>;
  static constexpr bool drifts = Blocks<S>::drifts;
  static constexpr std::size_t blocks = solved_blocks<S>;
  static constexpr bool has_matrix_mass = []<std::size_t... K>(std::index_sequence<K...>) {
    return (std::tuple_element_t<K, Masses>::is_matrix || ...);
  }
  (std::make_index_sequence<blocks>{});
  static constexpr Structure mass_structure = []<std::size_t... K>(std::index_sequence<K...>) {
    Structure all = Structure::none;
    ((all = combine(all, std::tuple_element_t<K, Masses>::structure)), ...);
    return all;
  }
  (std::make_index_sequence<blocks>{});
  /// M may turn out to be singular, so that some of the equations are algebraic.
  static constexpr bool may_be_singular = []<std::size_t... K>(std::index_sequence<K...>) {
    return !drifts && (MayBeSingular<std::tuple_element_t<K, Masses>> || ...);
  }
  (std::make_index_sequence<blocks>{});
  static constexpr bool takes_active =
      requires(std::tuple_element_t<0, Masses>& mass, std::shared_ptr<const ActiveSet> active) {
    mass.set_active(active);
  };
  static constexpr bool is_autonomous = !Traits::uses_time;
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
  /// A component without an equation for its rate, named by block and index; none where M is regular.
  [[nodiscard]] Offender algebraic() const {
    Offender found;
    for_each_masses([&found](auto k, const auto& mass) {
      if constexpr (MayBeSingular<std::remove_cvref_t<decltype(mass)>>)
        if (const Index i = mass.algebraic(); i >= 0 && !found) found.block = k, found.index = i;
    });
    return found;
  }
  /// psi ← what is no M y': what the algebraic equations leave.
  void keep_unexplained(Rate& psi) const {
    for_each_block([](auto, auto& rate, const auto& mass) { keep<false>(mass, flat(rate)); }, Rate::blocks(psi),
                   masses_);
  }
  /// x ← what M doesn't see of it.
  void keep_unseen(Plain& x) const {
    for_each_block([](auto, auto& block, const auto& mass) { keep<true>(mass, flat(block)); }, Blocks<S>::solved(x),
                   masses_);
  }
  [[nodiscard]] Statistics& statistics() { return statistics_; }
  [[nodiscard]] const Statistics& statistics() const { return statistics_; }
  [[nodiscard]] View view(const Plain& y) const { return Blocks<S>::view(y, masses_); }

  /// The committed history, by value: part of a checkpoint.
  [[nodiscard]] const Memory& memory() const { return committed_; }
  void set_memory(Memory memory) { committed_ = std::move(memory); }
  void save(Writer& out) const {
    save_parts(out, "memory", MemoryArchive<Whole, const Memory>{&committed_}, "counts", statistics_);
  }
  void load(Reader& in, auto&& then) {
    Memory read = committed_;
    MemoryArchive<Whole> memory{&read};
    load_parts(in, then, "memory", memory, "counts", statistics_);
    committed_ = std::move(read);
  }
  /// The history that Ψ sees during a step.
  [[nodiscard]] decltype(auto) trial_memory() const {
    if constexpr (split) return Parts<Whole>::template memory<false>(trial_);
    else return (trial_);
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
      const auto& result = returned_force(force(), view(y), t, psi);
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
      held_->run([&] { assign_force(force(), t, view(y), trial_memory(), psi); },
                 [&] { for_each_block([](auto, auto& block) { block.poison(); }, Rate::blocks(psi)); });
    } else {
      assign_force(force(), t, view(y), trial_memory(), psi);
    }
  }
  /// What the force, or a solver, of a field has thrown on this rank.
  [[nodiscard]] const std::shared_ptr<HeldException>& held() const requires FieldState<Plain> { return held_; }
  /// psi = Ψ_e(t, y), the kicks.
  void evaluate_kicks(Scalar t, const Plain& y, Rate& psi) {
    ++statistics_.kick_calls;
    auto&& kicks = Parts<Whole>::template of<true>(unwrap(*force_));
    assign_force(kicks, t, view(y), Parts<Whole>::template memory<true>(trial_), psi);
  }

  /// out = y' = (v, M⁻¹Ψ), by a force call. False: it isn't finite.
  [[nodiscard]] bool slope(Scalar t, const Plain& y, Plain& out, Rate& psi) {
    evaluate_into(t, y, psi);
    if constexpr (drifts) std::get<0>(Blocks<S>::all(out)) = std::get<1>(Blocks<S>::all(y));
    bool finite = true;
    for_each_block(
        [&finite](auto, auto& to, const auto& rate, const auto& mass) {
          if constexpr (FieldState<Plain>) {
            to = uniform_mass(mass).scaled(Scalar{1}).factor * rate;
            finite = is_finite_block(to) && finite;
          } else {
            to = rate;
            finite = all_finite(to.data(), to.size()) && finite;
            if constexpr (std::remove_cvref_t<decltype(mass)>::is_matrix)
              if (finite) mass.solve(flat(to));
            const auto factor = mass.scaled(Scalar{1});
            for (Index i = 0; i < to.size(); ++i) to.data()[i] = factor(i) * to.data()[i];
          }
        },
        Blocks<S>::solved(out), Rate::blocks(psi), masses_);
    return finite;
  }
  /// The same between steps, with the kicks of a split scene.
  [[nodiscard]] bool whole_slope(Scalar t, const Plain& y, Plain& out, Rate& psi) {
    begin(t, Scalar{0}, y);  // a force may make its history at its first step
    if constexpr (remembers && has_inner_steps) begin_force(whole_force(), t, Scalar{0}, view(y), trial_);
    bool finite = slope(t, y, out, psi);
    if constexpr (split) {
      evaluate_kicks(t, y, psi);
      finite = kick(out, Scalar{1}, Rate::blocks(std::as_const(psi)), psi) && finite;
    }
    return finite;
  }

  /// out = y + γ M⁻¹Ψ, all blocks and the drift in one pass each; `out` may be y. False: something isn't finite.
  template <bool with_drift = drifts, class Psi>
  [[nodiscard, gnu::always_inline]] static inline bool advance(Plain& out, const Plain& y, const auto& by,
                                                               const Psi& psi, Rate& scratch, const Masses& masses) {
    if constexpr (FieldState<Plain>) {
      return advance_fields<with_drift>(out, y, by, psi, masses);
    } else if constexpr (has_matrix_mass) {
      for_each_block(
          [](auto, auto& to, const auto& from, const auto& mass) {
            if (&to != &from) to = from;
            // In storage order, as everywhere. M⁻¹ would spread a NaN over all components, and hide which one had it.
            if constexpr (std::remove_cvref_t<decltype(mass)>::is_matrix)
              if (all_finite(to.data(), to.size())) mass.solve(flat(to));
          },
          Rate::blocks(scratch), psi, masses);
      return advance_componentwise<with_drift>(out, y, by, Rate::blocks(std::as_const(scratch)), masses);
    } else {
      return advance_componentwise<with_drift>(out, y, by, psi, masses);
    }
  }

  /// … without a matrix for a mass: put(kernel, block of out…) for every pass that this takes (explicit_update.hpp), its blocks
  /// those of a state or of a view of one.
  template <bool with_drift = drifts, class Out>
  [[gnu::always_inline]] static inline void for_each_update(const Plain& y, const auto& by, const auto& psi,
                                                            const Masses& masses, auto&& put, Out& out) {
    for_each_block(
        [&](auto k, auto& to, const auto& from, const auto& rate, const auto& mass) PHISTEP_DETAIL_INLINED {
          const auto factor = mass.scaled(by.kick);
          if constexpr (with_drift && k == 0) {
            const Scalar* const r = std::get<0>(Blocks<S>::all(y)).data();
            const KickAndDrift kernel{Input{r}, Input{from.data()}, Input{rate.data()}, factor, by.before, by.after};
            put(kernel, to, std::get<0>(Blocks<S>::all(out)));
          } else {
            const phistep::Kick kernel{Input{from.data()}, Input{rate.data()}, factor};
            put(kernel, to);
          }
        },
        Blocks<S>::solved(out), Blocks<S>::solved(y), psi, masses);
  }

  /// The same of some particles; `out` has the others.
  template <bool with_drift = drifts>
  [[nodiscard]] bool advance_some(Plain& out, const Plain& y, const Advance<Scalar>& by, const auto& psi,
                                  const std::vector<std::int32_t>& particles) const {
    FiniteWitness<Scalar> witness;
    for_each_update<with_drift>(
        y, by, psi, masses_,
        [&](const auto& kernel, auto& to, auto&... position) {
          for (const Index i : particles)
            for (Index k = to.rows() * i; k < to.rows() * (i + 1); ++k)
              [&](auto... result) {  // beside: `out` may be y
                kernel(k, result...);
                std::tie(to.data()[k], position.data()[k]...) = std::tie(result...);
                (witness.see(result), ...);
              }(Scalar{}, (static_cast<void>(position), Scalar{})...);
        },
        out);
    return witness.all_finite();
  }

  /// y.solved += γ M⁻¹Ψ.
  template <class Psi>
  [[nodiscard]] bool kick(Plain& y, Scalar gamma, const Psi& psi, Rate& scratch) const {
    return kick(y, gamma, psi, scratch, masses_);
  }
  template <class Psi>
  [[nodiscard, gnu::always_inline]] static inline bool kick(Plain& y, Scalar gamma, const Psi& psi, Rate& scratch,
                                                            const Masses& masses) {
    return advance<false>(y, y, Advance{gamma, Zero{}, Zero{}}, psi, scratch, masses);
  }
  /// r += h v.
  void drift(Plain& y, Scalar h) const {
    if constexpr (drifts) std::get<0>(Blocks<S>::all(y)) += h * std::get<1>(Blocks<S>::all(y));
  }
  [[nodiscard]] static bool is_finite(const Plain& y) { return all_finite(Blocks<S>::all(y)); }
  void rebind(Masses masses) { masses_ = std::move(masses); }
  /// The particles that are computed from now on (state/active_set.hpp): hands the set to the masses that take one. True where
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
  /// What is known of the particles outside it, for forces to see.
  void set_left_out(const LeftOut& known) requires takes_active {
    if (std::get<0>(masses_).left_out() != known) std::get<0>(masses_).set_left_out(known);
  }

  /// Which term of a sum spoils Ψ at (t, y), for messages; −1 where that can't be told.
  [[nodiscard]] int offending_term(Scalar t, const Plain& y) {
    if constexpr (FieldState<Plain>) return -1;  // ranks that ask again could come to different answers
    Rate scratch = make_rate<S>(y);
    try {
      return phistep::offending_term(whole_force(), t, view(y), trial_, scratch);
    } catch (...) {  // the caller is already reporting a failure; asking again must not add another
      return -1;
    }
  }

  /// Where Ψ was read from the user's own array, the workspace doesn't show it: look again.
  [[nodiscard]] bool is_non_finite_at(Scalar t, const Plain& y, Offender& where) {
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
  /// A field's mass, which is a number.
  template <class Mass>
  [[nodiscard]] static const Mass& uniform_mass(const Mass& mass) {
    static_assert(
        requires { mass.scaled(Scalar{1}).factor; } && !Mass::is_matrix,
        "phistep: a field's mass is 1 or one number, mass(2.0): divide the force by any other");
    return mass;
  }
  template <bool with_drift>
  [[nodiscard]] static bool advance_fields(Plain& out, const Plain& y, const auto& by, const auto& psi,
                                           const Masses& masses) {
    for_each_block(
        [&](auto k, auto& to, const auto& from, const auto& rate, const auto& mass) {
          const Scalar factor = uniform_mass(mass).scaled(by.kick).factor;
          // r⁺ = r + before v + after v⁺ first, for out may be y
          if constexpr (with_drift && k == 0)
            std::get<0>(Blocks<S>::all(out)) =
                std::get<0>(Blocks<S>::all(y)) + (by.before + by.after) * from + (by.after * factor) * rate;
          to = from + factor * rate;
        },
        Blocks<S>::solved(out), Blocks<S>::solved(y), psi, masses);
    return is_finite(out);
  }
  void for_each_masses(auto&& f) const {
    [&]<std::size_t... K>(std::index_sequence<K...>) {
      (f(std::integral_constant<std::size_t, K>{}, std::get<K>(masses_)), ...);
    }
    (std::make_index_sequence<blocks>{});
  }
  template <bool unseen>
  static void keep(const auto& mass, auto&& x) {
    if constexpr (!MayBeSingular<std::remove_cvref_t<decltype(mass)>>) x.setZero();
    else if constexpr (unseen) mass.keep_unseen(x);
    else mass.keep_unexplained(x);
  }
  template <bool with_drift, class Psi>
  [[nodiscard, gnu::always_inline]] static inline bool advance_componentwise(Plain& out, const Plain& y, const auto& by,
                                                                             const Psi& psi, const Masses& masses) {
    bool finite = true;
    for_each_update<with_drift>(
        y, by, psi, masses,
        [&](const auto& kernel, auto& to, auto&... position) PHISTEP_DETAIL_INLINED {
          constexpr int size = std::remove_cvref_t<decltype(to)>::SizeAtCompileTime;
          finite = update_sized<size>(&out == &y, to.size(), kernel, to.data(), position.data()...) && finite;
        },
        out);
    return finite;
  }

  template <int size>
  [[nodiscard, gnu::always_inline]] static inline bool update_sized(bool in_place, Index n, const auto& kernel,
                                                                    auto*... out) {
    if constexpr (size != Eigen::Dynamic && size <= 64) return update_unrolled<size>(kernel, out...);
    else return in_place ? update_in_place(n, kernel, out...) : update(n, kernel, out...);
  }

  struct Nothing {};
  Assignable<F> force_;
  [[no_unique_address]] std::conditional_t<gathers, std::optional<Force>, Nothing> rest_;  // made anew at each use
  [[no_unique_address]] Masses masses_;
  [[no_unique_address]] Memory committed_{};
  [[no_unique_address]] Memory trial_{};
  [[no_unique_address]] std::conditional_t<FieldState<Plain>, std::shared_ptr<HeldException>, Nothing> held_;
  Statistics statistics_;
};

/// put(i, j, m) for each entry of M over all unknowns: a function of `put` that refers to both arguments.
template <State S>
[[nodiscard]] auto each_mass_entry(const auto& rhs, const PlainState<S>& y) {
  return [&rhs, &y](auto&& put) {
    for_each_part(
        [&put](Index at, const auto& block, const auto& mass) {
          for_each_inertia(mass, block.size(), [&](Index i, Index j, auto m) { put(at + i, at + j, m); });
        },
        Blocks<S>::solved(y), rhs.masses());
  };
}

}  // namespace phistep::inline PHISTEP_ABI
