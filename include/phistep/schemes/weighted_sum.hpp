/// @file
/// Sums of a few arrays with weights known at compile time: unrolled, zeros left out, one pass over all arrays,
///
///     x + h Σ_j w_j k_j
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/numbers/update.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @tparam Weights  count, and at(j) = w_j as a long double
/// @tparam Rate     what the k_j are
/// @tparam exact    with what Scalar's weights lack: as an error of each step alike, that would add up in long runs
/// @tparam block    of the rates k_j
template <class Weights, class Rate, bool exact = false, std::size_t block = 0>
class WeightedSum {
  using Block = std::remove_cvref_t<decltype(std::get<block>(Rate::blocks(std::declval<const Rate&>())))>;
  using Scalar = typename Block::Scalar;
  using Used = NonZero<Weights, Scalar>;
  static constexpr std::size_t used = Used::count;
  template <std::size_t n>
  static constexpr Scalar high = Used::template of<n>;
  template <std::size_t n>
  static constexpr Scalar low = static_cast<Scalar>(Weights::at(Used::places[n]) - static_cast<long double>(high<n>));
  using All = typename Used::Indices;

 public:
  static constexpr bool is_empty = used == 0;
  template <std::size_t stages>
  explicit WeightedSum(const std::array<Rate, stages>& k) : WeightedSum{k, All{}} {}

  /// Σ_j w_j k_j(i), i an index or a packet of them
  [[gnu::always_inline]] auto operator()(auto i) const { return sum(i, All{}); }
  /// x + h Σ_j w_j k_j(i). The last k is the one that the processor still waits for: the others are ready by then.
  [[gnu::always_inline]] auto add_to(auto x, Scalar h, auto i) const {
    if constexpr (used > 1) x = x + h * sum(i, std::make_index_sequence<used - 1>{});
    return x + (h * high<used - 1>)*at<used - 1>(i);
  }

 private:
  /// [numbers] From one k_j of fixed size to the next: one pointer, and places known at compile time. 0: each has an array of
  /// its own.
  static constexpr std::ptrdiff_t stride =
      Block::SizeAtCompileTime == Eigen::Dynamic ? 0 : static_cast<std::ptrdiff_t>(sizeof(Rate) / sizeof(Scalar));
  template <std::size_t stages, std::size_t... n>
  WeightedSum(const std::array<Rate, stages>& k, std::index_sequence<n...>) {
    const auto data = [&k](std::size_t j) { return std::get<block>(Rate::blocks(k[j])).data(); };
    if constexpr (stride != 0) k_ = data(0);
    else k_ = {Input<Scalar>{data(Used::places[n])}...};
  }
  /// The n-th used k at i
  template <std::size_t n>
  [[nodiscard, gnu::always_inline]] auto at(auto i) const {
    if constexpr (stride != 0) return Input<Scalar>{k_ + static_cast<std::ptrdiff_t>(Used::places[n]) * stride}[i];
    else return k_[n][i];
  }
  template <std::size_t... n>
  [[gnu::always_inline]] auto sum(auto i, std::index_sequence<n...>) const {
    if constexpr (exact) {
      // From the small ones on: added to what is rounded already, they would be rounded away, time after time.
      auto x = (... + (low<n> * at<n>(i)));
      ((x = x + high<n> * at<n>(i)), ...);
      return x;
    } else {
      return (... + (high<n> * at<n>(i)));
    }
  }

  std::conditional_t<stride != 0, const Scalar*, std::array<Input<Scalar>, used>> k_;
};

}}  // namespace phistep::PHISTEP_ABI
