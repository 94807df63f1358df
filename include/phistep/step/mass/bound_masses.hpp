/// @file
/// M of M y' = Ψ for a state of several blocks: a tuple with the mass of each solved block, bound to its size.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/mass/mass.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The masses that the user gave, bound to the solved blocks of y. @throws std::invalid_argument where sizes differ
template <State S, class Plain>
[[nodiscard]] auto bind_masses(UnitMasses, const Plain& y) {
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

/// What the types of bound masses say about M.
template <class Masses, class Scalar>
struct MassFacts;
template <class... M, class Scalar>
struct MassFacts<std::tuple<M...>, Scalar> {
  static_assert((BoundMass<M, Scalar> && ...));
  static constexpr bool are_ones = (std::is_same_v<M, UnitMass> && ...);
  static constexpr bool has_matrix = (M::is_matrix || ...);
  static constexpr bool may_be_singular = (MayBeSingular<M> || ...);
  static constexpr Structure structure = [] {
    Structure all = Structure::none;
    ((all = combine(all, M::structure)), ...);
    return all;
  }();
};

/// h/m of a field, whose mass is a number.
template <class Mass, class Scalar>
[[nodiscard]] Scalar field_factor(const Mass& mass, Scalar h) {
  static_assert(
      requires { mass.h_over_mass(h).factor; } && !Mass::is_matrix,
      "phistep: a field's mass is 1 or one number, mass(2.0): divide the force by any other");
  return mass.h_over_mass(h).factor;
}

/// x ← M⁻¹ x of a block. False where a mass matrix would spread what isn't finite over all components: x is then as it was.
template <class Mass>
[[nodiscard]] bool divide_by_mass(auto& x, const Mass& mass) {
  using Scalar = typename std::remove_cvref_t<decltype(x)>::Scalar;
  if constexpr (std::is_same_v<Mass, UnitMass>) {
    return true;
  } else if constexpr (FieldBlock<decltype(x)>) {
    x *= field_factor(mass, Scalar{1});
  } else if constexpr (Mass::is_matrix) {
    if (!is_finite_block(x)) return false;
    mass.solve(flat(x));
  } else {
    const auto factor = mass.h_over_mass(Scalar{1});
    for (Index i = 0; i < x.size(); ++i) x.data()[i] = factor(i) * x.data()[i];
  }
  return true;
}
/// The same for all solved blocks.
template <class... Block>
[[nodiscard]] bool divide_by_mass(const std::tuple<Block&...>& blocks, const auto& masses) {
  bool done = true;
  for_each_block([&done](auto, auto& x, const auto& mass) { done = done && divide_by_mass(x, mass); }, blocks, masses);
  return done;
}

/// A component without an equation for its rate, named by block and index; none where M is regular.
[[nodiscard]] ComponentLocation algebraic_component(const auto& masses) {
  ComponentLocation found;
  for_each_block(
      [&found](auto k, const auto& mass) {
        if constexpr (MayBeSingular<std::remove_cvref_t<decltype(mass)>>)
          if (const Index i = mass.algebraic(); i >= 0 && !found) found.block = k, found.index = i;
      },
      masses);
  return found;
}
/// f(mass, block) where a mass may be singular; other blocks become zero.
void keep_of_singular(const auto& blocks, const auto& masses, auto&& f) {
  for_each_block(
      [&f](auto, auto& block, const auto& mass) {
        if constexpr (MayBeSingular<std::remove_cvref_t<decltype(mass)>>) f(mass, flat(block));
        else block.setZero();
      },
      blocks, masses);
}
/// rates ← its part outside the range of M: the residual of the algebraic equations.
void keep_unexplained(const auto& rates, const auto& masses) {
  keep_of_singular(rates, masses, [](const auto& mass, auto&& rate) { mass.keep_unexplained(rate); });
}
/// Solved blocks ← what M doesn't see of them.
void keep_unseen(const auto& blocks, const auto& masses) {
  keep_of_singular(blocks, masses, [](const auto& mass, auto&& block) { mass.keep_unseen(block); });
}

/// put(i, j, m) for each entry of M over all unknowns: a function of `put` that refers to both arguments.
template <State S>
[[nodiscard]] auto each_mass_entry(const auto& masses, const PlainState<S>& y) {
  return [&masses, &y](auto&& put) {
    for_each_part(
        [&put](Index at, const auto& block, const auto& mass) {
          for_each_inertia(mass, block.size(), [&](Index i, Index j, auto m) { put(at + i, at + j, m); });
        },
        Blocks<S>::solved(y), masses);
  };
}

// Which masses an equation can't have.

/// The first block of m v' = Ψ that is solved for needs a mass > 0: ½ vᵀMv is an energy, > 0 wherever v ≠ 0. Numbers were checked where they were given,
/// but for zeros. Blocks beside it, such as temperatures, have a regular M.
/// @throws std::invalid_argument
void refuse_masses_of_motion(const auto& masses) {
  if (const ComponentLocation at = algebraic_component(masses))
    throw std::invalid_argument("phistep: a mass of motion must be > 0, and a mass matrix invertible: component " +
                                std::to_string(at.index));
  for_each_block(
      [](auto k, const auto& mass) {
        if constexpr (k == 0 && std::remove_cvref_t<decltype(mass)>::is_matrix)
          if (!mass.is_positive_definite())
            throw std::invalid_argument(
                "phistep: a mass matrix of motion must be symmetric and positive definite, as 1/2 v^T M v is an "
                "energy");
      },
      masses);
}

/// M y' = Ψ needs a regular M where the scheme or its solver needs M⁻¹.
/// @throws std::invalid_argument
void refuse_singular_masses(const auto& masses, const std::string& scheme) {
  if (const ComponentLocation at = algebraic_component(masses))
    throw std::invalid_argument(
        "phistep: M is singular (component " + std::to_string(at.index) + " of block " + std::to_string(at.block) +
        " is algebraic) and " + scheme +
        ", or its solver, needs its inverse: take rodas4, rodas5p, tr_bdf2 or backward_euler with newton()");
}

}}  // namespace phistep::PHISTEP_ABI
