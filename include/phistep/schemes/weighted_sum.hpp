/// @file
/// Sums of a few arrays with weights known at compile time: unrolled, zeros left out, one pass over all arrays,
///
///     x + h Σ_j w_j k_j
#pragma once

#include <array>
#include <cstddef>
#include <tuple>
#include <utility>

#include "phistep/core/version.hpp"
#include "phistep/simd/update.hpp"
#include "phistep/state/combination.hpp"

namespace phistep::inline PHISTEP_ABI {

/// @tparam Weights  count, and at(j) = w_j as a long double
/// @tparam exact    with what Scalar's weights lack: as an error of each step alike, that would add up in long runs
/// @tparam block    of the rates k_j
template <class Weights, class Scalar, bool exact = false, std::size_t block = 0>
class WeightedSum {
  using Used = NonZero<Weights, Scalar>;
  static constexpr std::size_t used = Used::count;
  template <std::size_t n>
  static constexpr Scalar high = Used::template of<n>;
  template <std::size_t n>
  static constexpr Scalar low = static_cast<Scalar>(Weights::at(Used::places[n]) - static_cast<long double>(high<n>));
  using All = typename Used::Indices;

 public:
  static constexpr bool is_empty = used == 0;
  template <class Rate, std::size_t stages>
  explicit WeightedSum(const std::array<Rate, stages>& k) : WeightedSum{k, All{}} {}

  /// Σ_j w_j k_j(i), i an index or a packet of them
  [[gnu::always_inline]] auto operator()(auto i) const { return sum(i, All{}); }
  /// x + h Σ_j w_j k_j(i). The last k is the one that the processor still waits for: the others are ready by then.
  [[gnu::always_inline]] auto add_to(auto x, Scalar h, auto i) const {
    if constexpr (used > 1) x = x + h * sum(i, std::make_index_sequence<used - 1>{});
    return x + (h * high<used - 1>)*k_[used - 1][i];
  }

 private:
  template <class Rate, std::size_t stages, std::size_t... n>
  WeightedSum(const std::array<Rate, stages>& k, std::index_sequence<n...>)
      : k_{{{std::get<block>(Rate::blocks(k[Used::places[n]])).data()}...}} {}
  template <std::size_t... n>
  [[gnu::always_inline]] auto sum(auto i, std::index_sequence<n...>) const {
    if constexpr (exact) {
      // From the small ones on: added to what is rounded already, they would be rounded away, time after time.
      auto x = (... + (low<n> * k_[n][i]));
      ((x = x + high<n> * k_[n][i]), ...);
      return x;
    } else {
      return (... + (high<n> * k_[n][i]));
    }
  }

  std::array<Input<Scalar>, used> k_;
};

}  // namespace phistep::inline PHISTEP_ABI
