/// @file
/// Which particles a term of a force may let act on each other: needed where some are left out.
#pragma once

#include <cstdint>
#include <tuple>

#include "phistep/base/version.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/force/local.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Who may act on whom. A term of pairs offers `for_each_pair(memory, f)`, with f(i, j) called for every pair that acts or
/// may soon act, indices being the user's, and `pair_changes()`, a number that changes where others may act from now on
/// (without it, pairs are asked for at each step); `acts_by_touch` says that spheres apart don't act. One that acts on each
/// particle by itself says `acts_on_each`.
template <class F, int dim>
inline constexpr bool tells_its_pairs = requires(F& f, const MemoryOf<F>& memory, void (*pair)(Index, Index)) {
  f.for_each_pair(memory, pair);
}
|| is_particlewise<F, dim> || requires { requires F::acts_on_each; };
template <class... T, int dim>
inline constexpr bool tells_its_pairs<Sum<T...>, dim> = (tells_its_pairs<Unwrapped<T>, dim> && ...);

/// pair(i, j, by_touch) for all.
template <class F, class Memory, class Pair>
void for_each_pair_of(F& force, const Memory& memory, Pair&& pair) {
  constexpr bool by_touch = requires { requires F::acts_by_touch; };
  const auto put = [&pair](Index i, Index j) { pair(i, j, by_touch); };
  if constexpr (is_sum<F>)
    for_each_term(force, memory, [&pair](auto, auto& term, const auto& its) { for_each_pair_of(term, its, pair); });
  else if constexpr (requires { force.for_each_pair(memory, put); }) force.for_each_pair(memory, put);
}

/// A number that changes where for_each_pair_of changes; −1 where unknown.
template <class F>
[[nodiscard]] std::int64_t pair_changes_of(F& force) {
  if constexpr (is_sum<F>) {
    return std::apply(
        [](auto&... term) {
          const std::int64_t changes[] = {0, pair_changes_of(unwrap(term))...};
          std::int64_t sum = 0;
          for (const std::int64_t some : changes) sum = some < 0 || sum < 0 ? -1 : sum + some;
          return sum;
        },
        force.terms);
  } else if constexpr (requires { force.pair_changes(); }) {
    return static_cast<std::int64_t>(force.pair_changes());
  } else {
    constexpr bool has_pairs = requires(const MemoryOf<F>& memory, void (*pair)(Index, Index)) {
      force.for_each_pair(memory, pair);
    };
    return has_pairs ? -1 : 0;
  }
}

}}  // namespace phistep::PHISTEP_ABI
