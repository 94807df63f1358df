/// @file
/// A pass over the components of a block: for schemes whose kernels combine more than r and v.
#pragma once

#include <type_traits>

#include "phistep/base/numbers/update.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// kernel(i, x…) for every component of a block, out…[i] = x…; whether all are finite. `size` is the block's at compile
/// time: up to 8 numbers are unrolled; as many as fit registers are a plain loop of known length. Packets would wait there
/// for numbers that a force has just written one by one: such loads are not forwarded from the stores.
template <int size>
[[nodiscard, gnu::always_inline]] inline bool update_block(Index n, const auto& kernel, auto*... out) {
  if constexpr (0 < size && size <= 8) {
    return update_one_by_one<size>(kernel, out...);
  } else if constexpr (few_numbers(size)) {
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

}}  // namespace phistep::PHISTEP_ABI
