/// @file
/// Linear combinations of states, written as in the formula, computed in one pass a block:
///
///     const auto y = in<S>(step.y), Y = in<S>(stage);
///     assign<S>(step.next, y + beta * (Y - y));
///
/// The states must outlive the expression; the one assigned to may occur in it.
#pragma once

#include <tuple>
#include <type_traits>

#include "phistep/core/version.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Expressions: `block(k)` is that of block k, an Eigen expression.
namespace combination {
struct Expression {};
template <class X>
concept IsExpression = std::is_base_of_v<Expression, X>;

template <class Tie>
struct Leaf : Expression {
  Tie blocks;
  explicit Leaf(Tie tie) : blocks{tie} {}
  template <std::size_t k>
  [[nodiscard]] const auto& block() const {
    return std::get<k>(blocks);
  }
};
template <class A, class B>
struct Plus : Expression {
  A a;
  B b;
  Plus(const A& x, const B& y) : a{x}, b{y} {}
  template <std::size_t k>
  [[nodiscard]] auto block() const {
    return a.template block<k>() + b.template block<k>();
  }
};
template <class A, class B>
struct Minus : Expression {
  A a;
  B b;
  Minus(const A& x, const B& y) : a{x}, b{y} {}
  template <std::size_t k>
  [[nodiscard]] auto block() const {
    return a.template block<k>() - b.template block<k>();
  }
};
template <class Scalar, class A>
struct Times : Expression {
  Scalar factor;
  A a;
  Times(Scalar by, const A& x) : factor{by}, a{x} {}
  template <std::size_t k>
  [[nodiscard]] auto block() const {
    return factor * a.template block<k>();
  }
};
template <class Scalar, class A>
struct Over : Expression {
  Scalar divisor;
  A a;
  Over(Scalar by, const A& x) : divisor{by}, a{x} {}
  template <std::size_t k>
  [[nodiscard]] auto block() const {
    return a.template block<k>() / divisor;
  }
};

template <IsExpression A, IsExpression B>
[[nodiscard]] Plus<A, B> operator+(const A& a, const B& b) {
  return {a, b};
}
template <IsExpression A, IsExpression B>
[[nodiscard]] Minus<A, B> operator-(const A& a, const B& b) {
  return {a, b};
}
template <class Scalar, IsExpression A>
[[nodiscard]] Times<Scalar, A> operator*(Scalar factor, const A& a) {
  return {factor, a};
}
template <IsExpression A, class Scalar>
[[nodiscard]] Over<Scalar, A> operator/(const A& a, Scalar divisor) {
  return {divisor, a};
}
}  // namespace combination

/// A state in an expression.
template <State S, class Y>
[[nodiscard]] auto in(const Y& y) {
  return combination::Leaf{Blocks<S>::all(y)};
}

/// to = expression, block by block.
template <State S, class To, combination::IsExpression X>
void assign(To& to, const X& expression) {
  for_each_block([&](auto k, auto& block) { block = expression.template block<k()>(); }, Blocks<S>::all(to));
}
/// to += expression
template <State S, class To, combination::IsExpression X>
void add(To& to, const X& expression) {
  for_each_block([&](auto k, auto& block) { block += expression.template block<k()>(); }, Blocks<S>::all(to));
}
/// The same for the solved blocks alone (not for the r of a motion).
template <State S, class To, combination::IsExpression X>
void assign_solved(To& to, const X& expression) {
  constexpr std::size_t first = Blocks<S>::drifts ? 1 : 0;
  for_each_block([&](auto k, auto& block) { block = expression.template block<k() + first>(); }, Blocks<S>::solved(to));
}

}  // namespace phistep::inline PHISTEP_ABI
