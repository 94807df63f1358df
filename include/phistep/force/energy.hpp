/// @file
/// The potential energy of force terms, where they have one: an optional member
///
///     auto energy(auto t, const auto& y) const;        // V(t, r) [energy], −∂V/∂r being the term's force at v = 0
///
/// beside `add`, with the same view; a term with a memory may take it as well, energy(t, y, memory). No step calls it;
/// study/energy/energy_ledger.hpp does.
#pragma once

#include <concepts>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/version.hpp"
#include "phistep/force/annotate.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A force term with a potential energy. (Where that depends on its numbers, `bool has_energy() const` answers.)
template <class F, class View>
concept HasEnergy = requires(F& f, typename ViewScalar<View>::type t, const View& y) {
  { f.energy(t, y) } -> std::convertible_to<typename ViewScalar<View>::type>;
}
|| requires(F& f, typename ViewScalar<View>::type t, const View& y, const MemoryOf<F>& memory) {
  { f.energy(t, y, memory) } -> std::convertible_to<typename ViewScalar<View>::type>;
};

/// Whether a term has a potential energy, its numbers included.
template <class View, class F>
[[nodiscard]] bool has_energy(F& force) {
  if constexpr (!HasEnergy<F, View>) return false;
  else if constexpr (requires { force.has_energy(); }) return force.has_energy();
  else return true;
}

/// V(t, r) of a force with this memory [energy]; of a sum, that of those terms that have one. 0 where there is none.
template <class F, class View, class Memory, class Scalar>
[[nodiscard]] Scalar potential_energy(F& force, Scalar t, const View& y, const Memory& memory) {
  if constexpr (is_sum<std::remove_const_t<F>>) {
    Scalar sum{0};
    for_each_term(force, memory, [&](auto, auto& term, const auto& its) { sum += potential_energy(term, t, y, its); });
    return sum;
  } else if constexpr (HasEnergy<F, View>) {
    if (!has_energy<View>(force)) return Scalar{0};
    if constexpr (requires { force.energy(t, y, memory); }) return static_cast<Scalar>(force.energy(t, y, memory));
    else return static_cast<Scalar>(force.energy(t, y));
  } else {
    return Scalar{0};
  }
}
/// The same with a new memory: terms that keep neighbour lists make them for this one call.
template <class F, class View, class Scalar>
[[nodiscard]] Scalar potential_energy(F& force, Scalar t, const View& y) {
  return potential_energy(force, t, y, MemoryOf<std::remove_const_t<F>>{});
}

/// A force and its potential.
template <class F, class V>
struct WithEnergy : Callable<F> {
  V potential;
  constexpr WithEnergy(F f, V v) : Callable<F>(std::move(f)), potential(std::move(v)) {}

  template <class View>
    requires MotionLike<View>
  [[nodiscard]] auto energy(auto t, const View& y) const {
    if constexpr (std::is_invocable_v<const V&, decltype(y.r), decltype(t)>) {
      return potential(y.r, t);
    } else {
      static_assert(call_arity<F, View>() < 3,
                    "phistep: with_energy(f, V) needs V(r, t) for a force f(r, v, t); a driving force is better a term "
                    "of its own");
      return potential(y.r);
    }
  }
};

/// Gives a force its potential energy V(r), or V(r, t) [energy]: −∂V/∂r must be the force at v = 0. For a lambda, a term or
/// what `local<dim>(…)` takes:
///
///     auto pendulum = with_energy([](const Vec& r) -> Vec { return -9.81 * r.array().sin(); },
///                                 [](const Vec& r) { return -9.81 * r.array().cos().sum(); });
template <class F, class V>
[[nodiscard]] constexpr WithEnergy<F, V> with_energy(F force, V potential) {
  return {std::move(force), std::move(potential)};
}
template <class F, class V>
[[nodiscard]] constexpr Term<WithEnergy<F, V>> with_energy(Term<F> term, V potential) {
  return Term<WithEnergy<F, V>>{WithEnergy<F, V>{std::move(term.force), std::move(potential)}};
}

}}  // namespace phistep::PHISTEP_ABI
