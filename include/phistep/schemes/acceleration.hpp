/// @file
/// M⁻¹Ψ in place, and passes over the components of a motion's blocks: for schemes that need more than r and v in one.
#pragma once

#include <Eigen/Core>

#include <tuple>
#include <type_traits>

#include "phistep/core/version.hpp"
#include "phistep/linear/mass.hpp"
#include "phistep/simd/update.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Ψ ← M⁻¹Ψ, all blocks. False where a mass matrix would spread what isn't finite over all components.
template <class Rhs>
[[nodiscard]] bool accelerate(const Rhs& rhs, typename Rhs::Rate& psi) {
  bool good = true;
  for_each_block(
      [&good](auto, auto& a, const auto& mass) {
        using Mass = std::remove_cvref_t<decltype(mass)>;
        if constexpr (FieldBlock<decltype(a)>) {
          if constexpr (!std::is_same_v<Mass, UnitMass>) a *= mass.scaled(typename Rhs::Scalar{1}).factor;
        } else if constexpr (Mass::is_matrix) {
          good = all_finite(a.data(), a.size()) && good;
          if (good) mass.solve(flat(a));
        } else if constexpr (!std::is_same_v<Mass, UnitMass>) {
          const auto factor = mass.scaled(typename Rhs::Scalar{1});
          for (Index i = 0; i < a.size(); ++i) a.data()[i] = factor(i) * a.data()[i];
        }
      },
      Rhs::Rate::blocks(psi), rhs.masses());
  return good;
}

/// kernel(i, x…) for every component of a block, out…[i] = x…; whether all are finite. `size` is the block's at compile
/// time: a few numbers are unrolled; up to 64 are a plain loop of known length. Packets would wait there for numbers that a
/// force has just written one by one: such loads are not forwarded from the stores.
template <int size>
[[nodiscard, gnu::always_inline]] inline bool update_block(Index n, const auto& kernel, auto*... out) {
  if constexpr (0 < size && size <= 8) {
    return update_one_by_one<size>(kernel, out...);
  } else if constexpr (0 < size && size <= 64) {
    FiniteWitness<std::common_type_t<std::remove_cvref_t<decltype(*out)>...>> witness;
    const auto one = [&](Index i, auto... x) {
      kernel(i, x...);
      ((out[i] = x), ...);
      (witness.see(x), ...);
    };
    // At -O2 g++ vectorizes loops alone whose number of turns every packet's width divides.
    constexpr Index whole = size < 16 ? size : size / 8 * 8;
    PHISTEP_DETAIL_ELEMENTWISE
    for (Index i = 0; i < whole; ++i) one(i, std::remove_cvref_t<decltype(*out)>{}...);
    for (Index i = whole; i < size; ++i) one(i, std::remove_cvref_t<decltype(*out)>{}...);
    return witness.all_finite();
  } else {
    return update_in_place(n, kernel, out...);
  }
}

}  // namespace phistep::inline PHISTEP_ABI
