/// @file
/// The stages of an explicit pair, Runge-Kutta's or Nyström's: their slopes k_j = M⁻¹Ψ, how the first of them comes about, sums
/// of them with weights known at compile time, and to which of them a failure is due.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/numbers/update.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/step/mass/bound_masses.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// A pass over the components of a block: for schemes whose kernels combine more than r and v.

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

// Sums of a few arrays with weights known at compile time: unrolled, zeros left out, one pass over all arrays,
//
//     x + h Σ_j w_j k_j

/// The weights of one formula less those of another.
template <class One, class Other>
struct DifferenceOfWeights {
  static constexpr std::size_t count = One::count;
  static constexpr long double at(std::size_t j) { return One::at(j) - Other::at(j); }
};

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

/// @tparam exact  sums include what weights lose by rounding (WeightedSum)
template <State S, std::size_t stages, bool exact = false>
class ExplicitStages {
 public:
  using Scalar = ScalarOf<S>;
  using Rate = RateOf<S>;
  template <class Block>
  static constexpr int size_of = std::remove_cvref_t<Block>::SizeAtCompileTime;

  void resize(const PlainState<S>& y) { k_.fill(make_rate<S>(y)); }
  [[nodiscard]] Rate& operator[](std::size_t j) { return k_[j]; }
  [[nodiscard]] const Rate& operator[](std::size_t j) const { return k_[j]; }
  [[nodiscard]] const std::array<Rate, stages>& all() const { return k_; }

  /// k_j = M⁻¹Ψ(t, Y). False: it isn't finite.
  [[nodiscard]] bool evaluate(auto& rhs, std::size_t j, Scalar t, const PlainState<S>& Y) {
    rhs.evaluate_into(t, Y, k_[j]);
    return divide_by_mass(RateOf<S>::blocks(k_[j]), rhs.masses());
  }
  /// Σ_j w_j k_j of a block, for a kernel of update_block.
  template <class Weights, std::size_t block = 0>
  [[nodiscard]] auto sum() const {
    return WeightedSum<Weights, Rate, exact, block>{k_};
  }
  /// factor Σ_j w_j k_j of a field, as a term of a linear combination.
  template <class Weights, std::size_t block = 0>
  [[nodiscard]] auto field_sum(Scalar factor) const {
    using Used = NonZero<Weights, Scalar>;
    using Block = std::remove_cvref_t<decltype(std::get<block>(Rate::blocks(k_[0])))>;
    return [&]<std::size_t... n>(std::index_sequence<n...>) {
      return typename Block::template Combination<Used::count>{
          {(factor * Used::template of<n>)...}, {&std::get<block>(Rate::blocks(k_[Used::places[n]]))...}};
    }
    (typename Used::Indices{});
  }
  /// to = factor Σ_j w_j k_j: an error. Where it isn't finite, the norm of it will tell.
  template <class Weights, std::size_t block = 0>
  void put(Scalar factor, auto& to) const {
    if constexpr (FieldState<S>) {
      to = field_sum<Weights, block>(factor);
    } else {
      const auto kernel = [factor, sum = sum<Weights, block>()](auto i, auto& x)
                              PHISTEP_DETAIL_INLINED { x = factor * sum(i); };
      static_cast<void>(update_block<size_of<decltype(to)>>(to.size(), kernel, to.data()));
    }
  }
  /// psi: kept for the failure message: the first k that isn't finite.
  [[gnu::cold, gnu::noinline]] void blame(Rate& psi) const {
    psi = k_[0];
    for (const Rate& k : k_)
      if (first_non_finite(Rate::blocks(k))) {
        psi = k;
        return;
      }
  }

 private:
  std::array<Rate, stages> k_;
};

}}  // namespace phistep::PHISTEP_ABI
