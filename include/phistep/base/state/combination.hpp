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
#include <functional>
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

/// Expressions: `block<k>()` is that of block k, an Eigen expression.
namespace combination {
struct Expression {};
template <class X>
concept IsExpression = std::is_base_of_v<Expression, X>;

/// The blocks of a tie, of which the first stands for block `first`.
template <class Tie, std::size_t first>
struct Leaf : Expression {
  Tie blocks;
  explicit Leaf(Tie tie) : blocks{tie} {}
  template <std::size_t k>
  [[nodiscard]] const auto& block() const {
    return std::get<k - first>(blocks);
  }
};
template <std::size_t first, class Tie>
[[nodiscard]] Leaf<Tie, first> blocks_from(Tie tie) {
  return Leaf<Tie, first>{tie};
}
template <State S>
inline constexpr std::size_t first_solved = Blocks<S>::drifts ? 1 : 0;

/// A number, in every block.
template <class Scalar>
struct Number : Expression {
  Scalar x;
  explicit Number(Scalar value) : x{value} {}
  template <std::size_t k>
  [[nodiscard]] Scalar block() const {
    return x;
  }
};
template <class Operation, class A, class B>
struct Joined : Expression {
  A a;
  B b;
  Joined(const A& x, const B& y) : a{x}, b{y} {}
  template <std::size_t k>
  [[nodiscard]] auto block() const {
    return Operation{}(a.template block<k>(), b.template block<k>());
  }
};
/// Σ_j w_j x_j from the left, which begins with `before` where that is an expression.
template <State S, class Weights, class Before, std::size_t count>
struct Sum : Expression {
  using Used = NonZero<Weights, ScalarOf<S>>;
  static_assert(Used::count > 0);
  const std::array<PlainState<S>, count>& x;
  [[no_unique_address]] Before before;
  template <std::size_t k>
  [[nodiscard]] auto block() const {
    return from_the_left<k>(typename Used::Indices{});
  }

 private:
  template <std::size_t k, std::size_t... n>
  [[nodiscard]] auto from_the_left(std::index_sequence<n...>) const {
    if constexpr (IsExpression<Before>) return (before.template block<k>() + ... + term<k, n>());
    else return (... + term<k, n>());
  }
  template <std::size_t k, std::size_t n>
  [[nodiscard]] auto term() const {
    return Used::template of<n> * std::get<k>(Blocks<S>::all(x[Used::places[n]]));
  }
};

template <IsExpression A, IsExpression B>
[[nodiscard]] Joined<std::plus<>, A, B> operator+(const A& a, const B& b) {
  return {a, b};
}
template <IsExpression A, State S, class Weights, std::size_t count>
[[nodiscard]] Sum<S, Weights, A, count> operator+(const A& a, const Sum<S, Weights, Absent<>, count>& b) {
  return {{}, b.x, a};
}
template <IsExpression A, IsExpression B>
[[nodiscard]] Joined<std::minus<>, A, B> operator-(const A& a, const B& b) {
  return {a, b};
}
template <class Scalar, IsExpression A>
[[nodiscard]] Joined<std::multiplies<>, Number<Scalar>, A> operator*(Scalar factor, const A& a) {
  return {Number{factor}, a};
}
template <IsExpression A, class Scalar>
[[nodiscard]] Joined<std::divides<>, A, Number<Scalar>> operator/(const A& a, Scalar divisor) {
  return {a, Number{divisor}};
}

/// Each block of a tie becomes that of the expression, counted from `first`.
template <std::size_t first, std::size_t... k, class Tie, class X>
[[gnu::always_inline]] inline void assign_from(const Tie& to, const X& expression, std::index_sequence<k...>) {
  ((std::get<k>(to) = expression.template block<first + k>()), ...);
}
template <std::size_t first, class Tie, class X>
[[gnu::always_inline]] inline void assign_from(const Tie& to, const X& expression) {
  assign_from<first>(to, expression, std::make_index_sequence<std::tuple_size_v<Tie>>{});
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
  return combination::Sum<S, Weights, Absent<>, count>{{}, x, {}};
}

/// to = expression, block by block.
template <State S, class To, combination::IsExpression X>
[[gnu::always_inline]] inline void assign(To& to, const X& expression) {
  combination::assign_from<0>(Blocks<S>::all(to), expression);
}
/// to += expression
template <State S, class To, combination::IsExpression X>
[[gnu::always_inline]] inline void add(To& to, const X& expression) {
  assign<S>(to, in<S>(to) + expression);
}
/// The same for the solved blocks alone (not for the r of a motion).
template <State S, class To, combination::IsExpression X>
[[gnu::always_inline]] inline void assign_solved(To& to, const X& expression) {
  combination::assign_from<combination::first_solved<S>>(Blocks<S>::solved(to), expression);
}
/// The same for a rate.
template <State S, combination::IsExpression X>
[[gnu::always_inline]] inline void assign_rate(RateOf<S>& to, const X& expression) {
  combination::assign_from<combination::first_solved<S>>(RateOf<S>::blocks(to), expression);
}
template <State S, class To, combination::IsExpression X>
[[gnu::always_inline]] inline void add_solved(To& to, const X& expression) {
  assign_solved<S>(to, in<S>(to) + expression);
}

}}  // namespace phistep::PHISTEP_ABI
