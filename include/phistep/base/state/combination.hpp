/// @file
/// Linear combinations of states, written as in the formula, computed in one pass a block:
///
///     const auto y = in<S>(step.y), Y = in<S>(stage);
///     assign<S>(step.next, y + beta * (Y - y));
///
/// and over an array of stages, with weights known at compile time, those that are zero left out:
///
///     assign<S>(step.next, y + weighted_sum<S, TableRow<Tableau::a, i, i>>(stages));
///
/// The states must outlive the expression; the one assigned to may occur in it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Row i of a table as weights, its first n numbers: a type with `count` and `at(j)` = w_j.
template <const auto& table, std::size_t i, std::size_t n>
struct TableRow {
  static constexpr std::size_t count = n;
  static constexpr long double at(std::size_t j) { return table[i][j]; }
};

/// The weights that aren't zero, `of<n>` at `places[n]`.
template <class Weights, class Scalar>
struct NonZero {
  static constexpr std::size_t count = [] {
    std::size_t n = 0;
    for (std::size_t j = 0; j < Weights::count; ++j) n += Weights::at(j) != 0 ? 1 : 0;
    return n;
  }();
  static constexpr auto places = [] {
    std::array<std::size_t, count> at{};
    std::size_t n = 0;
    for (std::size_t j = 0; j < Weights::count; ++j)
      if (Weights::at(j) != 0) at[n++] = j;
    return at;
  }();
  template <std::size_t n>
  static constexpr Scalar of = static_cast<Scalar>(Weights::at(places[n]));
  using Indices = std::make_index_sequence<count>;
};

namespace combination {
/// The number of a block, as an argument.
template <std::size_t k>
using Place = std::integral_constant<std::size_t, k>;

/// `block(Place<k>{})` is that of block k, an Eigen expression.
template <class F>
struct Expression {
  F block;
};
template <class F>
Expression(F) -> Expression<F>;

/// The blocks of a tie, of which the first stands for block `first`.
template <std::size_t first, class Tie>
[[nodiscard]] auto blocks_from(Tie tie) {
  return Expression{[tie](auto place) -> decltype(auto) { return (std::get<place() - first>(tie)); }};
}
template <State S>
inline constexpr std::size_t first_solved = Blocks<S>::drifts ? 1 : 0;

/// Σ_j w_j x_j from the left, which begins with `before` where that is an expression's.
template <State S, class Weights, class Before, std::size_t count>
struct Sum {
  using Used = NonZero<Weights, ScalarOf<S>>;
  static_assert(Used::count > 0);
  const std::array<PlainState<S>, count>& x;
  [[no_unique_address]] Before before;
  template <std::size_t k>
  [[nodiscard]] auto operator()(Place<k> place) const {
    return [&]<std::size_t... n>(std::index_sequence<n...>) {
      if constexpr (std::is_same_v<Before, Absent<>>) return (... + term<k, n>());
      else return (before(place) + ... + term<k, n>());
    }
    (typename Used::Indices{});
  }

 private:
  template <std::size_t k, std::size_t n>
  [[nodiscard]] auto term() const {
    return Used::template of<n> * std::get<k>(Blocks<S>::all(x[Used::places[n]]));
  }
};

template <class A, class B>
[[nodiscard]] auto operator+(const Expression<A>& a, const Expression<B>& b) {
  return Expression{[a, b](auto place) { return a.block(place) + b.block(place); }};
}
template <class A, State S, class Weights, std::size_t count>
[[nodiscard]] auto operator+(const Expression<A>& a, const Expression<Sum<S, Weights, Absent<>, count>>& b) {
  return Expression{Sum<S, Weights, A, count>{b.block.x, a.block}};
}
template <class A, class B>
[[nodiscard]] auto operator-(const Expression<A>& a, const Expression<B>& b) {
  return Expression{[a, b](auto place) { return a.block(place) - b.block(place); }};
}
template <class Scalar, class A>
[[nodiscard]] auto operator*(Scalar factor, const Expression<A>& a) {
  return Expression{[factor, a](auto place) { return factor * a.block(place); }};
}
template <class A, class Scalar>
[[nodiscard]] auto operator/(const Expression<A>& a, Scalar divisor) {
  return Expression{[a, divisor](auto place) { return a.block(place) / divisor; }};
}

/// Each block of a tie becomes that of the expression, counted from `first`.
template <std::size_t first, class... Block, class F>
[[gnu::always_inline]] inline void assign_from(const std::tuple<Block...>& to, const Expression<F>& expression) {
  for_each_block([&expression](auto k, auto& block)
                     PHISTEP_DETAIL_INLINED { block = expression.block(Place<first + k()>{}); },
                 to);
}
}  // namespace combination

/// A state in an expression.
template <State S, class Y>
[[nodiscard]] auto in(const Y& y) {
  return combination::blocks_from<0>(Blocks<S>::all(y));
}
/// A rate in an expression, for the solved blocks.
template <State S>
[[nodiscard]] auto in_rate(const RateOf<S>& psi) {
  return combination::blocks_from<combination::first_solved<S>>(RateOf<S>::blocks(psi));
}
/// Σ_j w_j x_j in an expression; y + Σ_j w_j x_j is y + w_0 x_0 + w_1 x_1 + …, summed from the left.
/// @tparam Weights  a TableRow or the like
template <State S, class Weights, std::size_t count>
[[nodiscard]] auto weighted_sum(const std::array<PlainState<S>, count>& x) {
  static_assert(Weights::count <= count);
  return combination::Expression{combination::Sum<S, Weights, Absent<>, count>{x, {}}};
}

/// to = expression, block by block.
template <State S, class To, class F>
[[gnu::always_inline]] inline void assign(To& to, const combination::Expression<F>& expression) {
  combination::assign_from<0>(Blocks<S>::all(to), expression);
}
/// to += expression
template <State S, class To, class F>
[[gnu::always_inline]] inline void add(To& to, const combination::Expression<F>& expression) {
  assign<S>(to, in<S>(to) + expression);
}
/// The same for the solved blocks alone (not for the r of a motion).
template <State S, class To, class F>
[[gnu::always_inline]] inline void assign_solved(To& to, const combination::Expression<F>& expression) {
  combination::assign_from<combination::first_solved<S>>(Blocks<S>::solved(to), expression);
}
/// The same for a rate.
template <State S, class F>
[[gnu::always_inline]] inline void assign_rate(RateOf<S>& to, const combination::Expression<F>& expression) {
  combination::assign_from<combination::first_solved<S>>(RateOf<S>::blocks(to), expression);
}
template <State S, class To, class F>
[[gnu::always_inline]] inline void add_solved(To& to, const combination::Expression<F>& expression) {
  assign_solved<S>(to, in<S>(to) + expression);
}

/// Each number of y is up to 15/4 `by` of itself off, in ways that `number` chooses.
template <State S>
void move_numbers(S& y, std::uint64_t number, ScalarOf<S> by) {
  for_each_number(
      [number, by](std::size_t i, ScalarOf<S>& x) {
        // Neighbours, and neighbours in a grid of any width, go different ways.
        const std::uint64_t mixed = (i + 1) * 0x9E3779B97F4A7C15U ^ number * 0xD1B54A32D192ED03U;
        x *= 1 + static_cast<ScalarOf<S>>(2 * static_cast<int>((mixed ^ mixed >> 29) >> 60) - 15) / 4 * by;
      },
      Blocks<S>::all(y));
}

}}  // namespace phistep::PHISTEP_ABI
